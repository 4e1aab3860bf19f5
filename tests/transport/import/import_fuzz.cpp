// Mutated scenes, meshes and images: each gives a scene or an error, in bounded time.
#include <catch2/catch.hpp>

#include <random>

#include "tests/transport/import_support.h"
#include "transport/files/ply.h"

using namespace import_test;
using namespace raylex::transport;

namespace {

const std::string scene_text = R"(# a scene with most of the grammar
Option "integer seed" 3
Film "rgb" "integer xresolution" [ 20 ] "string filename" "a.exr" "bool savefp16" false
LookAt 0 1 4  0 1 0  0 1 0
Camera "perspective" "float fov" [ 39.5 ]
WorldBegin
Attribute "shape" "float alpha" 0.5
Texture "t" "spectrum" "checkerboard" "rgb tex1" [.1 .2 .3] "rgb tex2" [1e-1 +.5 0]
MakeNamedMaterial "m" "string type" "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" [ 400 3 700 4 ]
AttributeBegin
  AreaLightSource "diffuse" "blackbody L" 6500
  NamedMaterial "m"
  Rotate 30 0 1 0 Scale 1 -1 1 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 1 1 0 1 1 0 -1 -1 0 -1] "point2 uv" [0 0 1 0 1 1 0 1]
AttributeEnd
ObjectBegin "o" Material "diffuse" "texture reflectance" "t" Shape "sphere" "float radius" 2 ObjectEnd
ObjectInstance "o" ColorSpace "rec2020" LightSource "infinite" "rgb L" [1 2 3]
MediumInterface "" "" ReverseOrientation CoordinateSystem "here" CoordSysTransform "camera"
)";

const std::string ply_text =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float "
    "u\nproperty float v\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 "
    "0 1 2\n4 0 1 2 3\n";

std::string mutate(std::string text, std::mt19937& random) {
    const auto below = [&random](std::size_t n) {
        return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    for (std::size_t edits = 1 + below(4); edits > 0 && !text.empty(); --edits) {
        const std::size_t at = below(text.size()), length = std::min(text.size() - at, 1 + below(12));
        switch (below(6)) {
            case 0:
                text[at] = static_cast<char>(below(256));
                break;
            case 1:
                text.erase(at, length);
                break;
            case 2:
                text.insert(at, text.substr(below(text.size()), length));
                break;
            case 3:
                text.insert(at, 1, "\"[]#\\ \n0-e."[below(11)]);
                break;
            case 4:
                text.resize(at);
                break;
            default:
                std::swap(text[at], text[below(text.size())]);
                break;
        }
    }
    return text;
}

template <class Check>
void fuzz(const std::string& seed_text, int rounds, Check check) {
    std::mt19937 random(20240607);
    for (int i = 0; i < rounds; ++i) check(mutate(seed_text, random));
}

}  // namespace

TEST_CASE("mutated scenes give a scene or an error with a position", "[import][fuzz][law7]") {
    REQUIRE(import_pbrt_text(scene_text, "fuzz.pbrt"));
    int accepted = 0, refused = 0;
    fuzz(scene_text, 20000, [&](const std::string& text) {
        const auto scene = import_pbrt_text(text, "fuzz.pbrt");
        scene ? ++accepted : ++refused;
        if (!scene &&
            (scene.error().line == 0 || scene.error().message.empty() || scene.error().to_string().size() > 4000))
            FAIL_CHECK(scene.error().to_string() + "\nfor\n" + text);
    });
    CHECK(accepted > 100);  // the mutations reach both outcomes
    CHECK(refused > 100);
}

TEST_CASE("mutated PLY files give a mesh with valid indices or an error", "[import][ply][fuzz][law7]") {
    REQUIRE(parse_ply(ply_text, "fuzz.ply"));
    std::string binary = ply_text.substr(0, ply_text.find("end_header\n") + 11);
    binary.replace(binary.find("ascii"), 5, "binary_little_endian");
    binary +=
        std::string(4 * 5 * 4, '\0') + std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0\4\0\0\0\0\1\0\0\0\2\0\0\0\3\0\0\0", 30);
    REQUIRE(parse_ply(binary, "fuzz.ply"));
    for (const std::string& text : {ply_text, binary}) {
        int accepted = 0, refused = 0;
        fuzz(text, 10000, [&](const std::string& mutated) {
            const auto mesh = parse_ply(mutated, "fuzz.ply");
            mesh ? ++accepted : ++refused;
            if (!mesh) return;
            for (const auto* list : {&mesh->triangles, &mesh->quads})
                for (const std::uint32_t index : *list)
                    if (index >= mesh->positions.size())
                        FAIL_CHECK("index " << index << " of " << mesh->positions.size() << " in\n" << mutated);
        });
        CHECK(accepted > 100);
        CHECK(refused > 100);
    }
}
