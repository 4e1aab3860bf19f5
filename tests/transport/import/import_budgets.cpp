// Law 7 for hostile input: scenes that grow exponentially, files that unpack to any size, numbers out of range. Budgets
// are lowered, so that input that exceeds them is quick to make.
#include <catch2/catch.hpp>

#include <sys/stat.h>
#include <zlib.h>

#include <chrono>

#include "tests/support/budget_guard.h"
#include "tests/transport/import_support.h"
#include "transport/files/images/image.h"
#include "transport/files/ply.h"
#include "transport/materials/material.h"
#include "transport/scene/used_surfaces.h"
#include "transport/textures/texture.h"

using namespace import_test;
using namespace raylex::transport;
using raylex::test::BudgetGuard;

namespace {

std::string packed(const std::string& bytes) {
    z_stream stream{};
    REQUIRE(deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK);
    std::string result(deflateBound(&stream, bytes.size()) + 32, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = static_cast<uInt>(result.size());
    REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
    result.resize(stream.total_out);
    deflateEnd(&stream);
    return result;
}

std::string ply(const std::string& rows = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", const std::string& comment = "") {
    return "ply\nformat ascii 1.0\n" + comment +
           "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list "
           "uchar "
           "int vertex_indices\nend_header\n" +
           rows;
}

std::string message_of(const raylex::Status& status) {
    return status ? "" : status.error().to_string();
}
template <class T>
std::string message_of(const raylex::Result<T>& result) {
    return result ? "" : result.error().to_string();
}

raylex::Status build(const SceneDescription& scene) {
    auto textures = TextureTable::build(scene);
    if (!textures) return textures.error();
    auto materials = MaterialTable::build(scene, *textures);
    if (!materials) return materials.error();
    return raylex::success();
}

std::string number(int i) {
    return std::to_string(i);
}

}  // namespace

TEST_CASE("a mesh that unpacks to much more than its size is refused by its ratio, wherever the padding is",
          "[law7][budget]") {
    const Folder folder;
    const BudgetGuard guard("unpack_floor=1K");
    const std::string filling(1 << 20, ' ');
    CHECK(contains(message_of(read_ply(folder.write("a.ply.gz", packed(ply() + filling)))),
                   "the budget unpack_ratio is 100"));
    CHECK(contains(message_of(read_ply(folder.write("b.ply.gz", packed(ply("0", "comment" + filling + "\n"))))),
                   "unpack_ratio"));
    CHECK(read_ply(folder.write("c.ply.gz", packed(ply()))).ok());
    const BudgetGuard raised("unpack_ratio=2000");
    CHECK(read_ply(folder.write("a.ply.gz", packed(ply() + filling))).ok());
}

TEST_CASE("a PLY element count beyond all integers is an error, not a count of 0", "[law7][budget]") {
    for (const char* count :
         {"18446744073709551616", "99999999999999999999999", "9223372036854775808", "-1", "1e3", "3x", ""}) {
        std::string text = ply();
        text.replace(text.find("vertex 3") + 7, 1, count);
        INFO(count);
        const auto mesh = parse_ply(text, "a.ply");
        REQUIRE_FALSE(mesh);
        CHECK(mesh.error().line == 3);
    }
}

TEST_CASE("normals that are not finite are computed from the faces, with a warning that counts them",
          "[law7][import]") {
    const Folder folder;
    const std::string mesh =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float "
        "nx\n"
        "property float ny\nproperty float nz\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 0 0 1\n1 0 0 nan 0 1\n0 1 0 0 1e39 1\n5 5 5 -inf 0 0\n3 0 1 2\n";
    folder.write("a.ply", mesh);
    const auto scene =
        import_pbrt(folder.write("s.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"a.ply\"\n"));
    REQUIRE(scene);
    REQUIRE(scene->warnings.size() == 1);
    CHECK(contains(scene->warnings[0].message, "3 of the normals of 'a.ply' are zero or not finite"));
    CHECK(scene->shapes[0].normals[1] == Vec3{0, 0, 1});
    CHECK(scene->shapes[0].normals[2] == Vec3{0, 0, 1});
    const auto inline_scene = scene_of(
        "WorldBegin Shape \"trianglemesh\" \"integer indices\" [0 2 1] \"point3 P\" [0 0 0 1 0 0 0 1 0] "
        "\"normal N\" [0 0 -1 nan nan nan 0 0 -1]");
    REQUIRE(inline_scene.warnings.size() == 1);
    CHECK(contains(inline_scene.warnings[0].message, "1 of the normals of the mesh"));
    CHECK(inline_scene.shapes[0].normals[1] == Vec3{0, 0, -1});
}

TEST_CASE("zero normals, numbers in Windows spelling and invalid texture coordinates do not prevent loading a mesh",
          "[law7][import]") {
    const Folder folder;
    // The normals oppose the orientation of the face: the computed normal agrees with its neighbours.
    folder.write("a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
                 "property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n"
                 "element face 1\nproperty list uint8 uint32 vertex_indices\nproperty short group\n"
                 "element strange 2\nproperty list int double values\nend_header\n"
                 "0 0 0 0 0 -1 0 0\n1 0 0 0 0 0 1 nan\n1 1 0 -1.#IND 1.#QNAN 0 1 1\n0 1 0 0 0 -1 0 1\n"
                 "4 0 1 2 3 -7\n2 1 2\n0\n");
    const auto scene =
        import_pbrt(folder.write("s.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"a.ply\"\n"));
    if (!scene) FAIL(scene.error().to_string());
    REQUIRE(scene->warnings.size() == 2);
    CHECK(contains(scene->warnings[0].message, "2 of the normals of 'a.ply' are zero or not finite"));
    CHECK(contains(scene->warnings[1].message, "1 of the texture coordinates of 'a.ply' are not finite"));
    for (const auto& normal : scene->shapes[0].normals) CHECK(normal == Vec3{0, 0, -1});
    CHECK(scene->shapes[0].uvs[1] == StoredVec2{0, 0});
}

TEST_CASE("a number beyond float is an error at its position", "[law7][import]") {
    for (const char* text : {"WorldBegin\nLightSource \"point\" \"rgb I\" [1e39 1 1]",
                             "WorldBegin\nLightSource \"point\" \"float scale\" 1e39",
                             "WorldBegin\nMaterial \"conductor\" \"float roughness\" -1e40",
                             "WorldBegin\nShape \"sphere\" \"float radius\" 3.5e38",
                             "WorldBegin\nLightSource \"infinite\" \"blackbody L\" 1e300"}) {
        INFO(text);
        const raylex::Error error = error_of(text);
        CHECK(error.line == 2);
        CHECK(error.column > 1);
        CHECK(contains(error.message, "beyond the range of float"));
    }
}

TEST_CASE("a file may begin with a byte order mark", "[import]") {
    const Folder folder;
    folder.write("part.pbrt", "\xef\xbb\xbfShape \"plymesh\" \"string filename\" \"a.ply\"\n");
    folder.write("a.ply", "\xef\xbb\xbf" + ply());
    const auto scene = import_pbrt(folder.write("s.pbrt", "\xef\xbb\xbfWorldBegin\nInclude \"part.pbrt\"\n"));
    INFO(message_of(scene));
    REQUIRE(scene);
    CHECK(scene->shapes.size() == 1);
}

TEST_CASE("files that each include the next twice soon exceed a budget", "[law7][budget]") {
    const Folder folder;
    for (int i = 0; i < 29; ++i) {
        const std::string next = "Include \"" + number(i + 1) + ".pbrt\"\n";
        folder.write(number(i) + ".pbrt", next + next);
    }
    folder.write("29.pbrt", "# nothing\n");
    const auto scene = import_pbrt(folder.path("0.pbrt"));
    CHECK(contains(message_of(scene), "the budget include_files is 10000"));
    const BudgetGuard guard("include_repeats=1K");
    CHECK(contains(message_of(import_pbrt(folder.path("0.pbrt"))), "the budget include_repeats is 1024"));
    const BudgetGuard shallow("include_depth=5");
    CHECK(contains(message_of(import_pbrt(folder.path("0.pbrt"))), "the budget include_depth is 5"));
}

TEST_CASE("files of a scene must be regular files", "[law7][budget]") {
    const Folder folder;
    REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
    for (const std::string name : {"pipe", "/dev/zero", "."}) {
        const std::string text[] = {
            "Include \"" + name + "\"", "WorldBegin Shape \"plymesh\" \"string filename\" \"" + name + "\"",
            "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + name + "\"",
            "WorldBegin Material \"conductor\" \"spectrum eta\" \"" + name + "\""};
        for (const std::string& each : text) {
            INFO(each);
            const auto scene = import_pbrt(folder.write("s.pbrt", each));
            const std::string message = scene ? message_of(build(*scene)) : message_of(scene);
            CHECK(contains(message, name == "."      ? "this is a directory"
                                    : name == "pipe" ? "this is a pipe"
                                                     : "this is a device"));
        }
    }
}

TEST_CASE("mixes of mixes share their parts: each material is visited once", "[budget]") {
    std::string text = "WorldBegin MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n";
    for (int i = 1; i < 40; ++i)
        text += "MakeNamedMaterial \"m" + number(i) + "\" \"string type\" \"mix\" \"string materials\" [\"m" +
                number(i - 1) + "\" \"m" + number(i - 1) + "\"]\n";
    const SceneDescription scene = scene_of(text + "NamedMaterial \"m39\" Shape \"sphere\"\n");
    auto textures = TextureTable::build(scene);
    REQUIRE(textures);
    const auto materials = MaterialTable::build(scene, *textures);
    REQUIRE(materials);
    std::vector<LobeId> lobes;
    materials->material(scene.materials.size() - 1)->append_lobes(lobes);
    CHECK(lobes.size() == 1);
    CHECK(materials->material(scene.materials.size() - 1)->interior() ==
          nullptr);  // each is visited once, not 2^39 times
    const BudgetGuard guard("material_depth=38");
    CHECK(contains(message_of(build(scene)), "the budget material_depth is 38"));
}

TEST_CASE("textures that each use the previous one exceed a budget of depth or work, in linear time",
          "[law7][budget]") {
    const auto chain = [](int count, const std::string& type, const std::string& inputs) {
        std::string text = "WorldBegin Texture \"t0\" \"float\" \"checkerboard\"\n";
        for (int i = 1; i <= count; ++i) {
            std::string parameters = inputs;
            for (std::size_t at; (at = parameters.find('@')) != std::string::npos;)
                parameters.replace(at, 1, "t" + number(i - 1));
            text += "Texture \"t" + number(i) + "\" \"float\" \"" + type + "\" " + parameters + "\n";
        }
        return text;
    };
    const auto start = std::chrono::steady_clock::now();
    const SceneDescription deep = scene_of(chain(20'000, "scale", "\"texture tex\" \"@\" \"float scale\" .5"));
    CHECK(contains(message_of(build(deep)), "the budget texture_depth is 512"));
    // 0.1 s here; comparing each texture with all earlier ones took 20 s.
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < 5);
    CHECK(build(scene_of(chain(500, "scale", "\"texture tex\" \"@\" \"float scale\" .5"))).ok());
    const SceneDescription wide = scene_of(chain(39, "mix", "\"texture tex1\" \"@\" \"texture tex2\" \"@\""));
    const auto refused = build(wide);
    CHECK(contains(message_of(refused), "the budget texture_work is 100000"));
    CHECK(refused.error().line > 1);
}

TEST_CASE("nested blocks have a budget", "[law7][budget]") {
    std::string text = "WorldBegin\n";
    for (int i = 0; i < 5'000; ++i) text += "AttributeBegin\n";
    CHECK(contains(error_of(text).to_string(), "the budget block_depth is 4096"));
}

TEST_CASE("parameters of one directive have a budget", "[law7][budget]") {
    std::string distinct = "WorldBegin\nShape \"sphere\"\n", repeated = distinct;
    for (int i = 0; i < 5'000; ++i) {
        distinct += "\"float r" + std::to_string(i) + "\" 1 ";
        repeated += "\"float radius\" 1 ";
    }
    for (const std::string& text : {distinct, repeated}) {
        const Error error = error_of(text);
        CHECK(contains(error.message, "the budget parameters is 4096"));
        CHECK(error.line == 3);
    }
}

TEST_CASE("parameters set by Attribute have a budget and linear cost per shape", "[law7][budget]") {
    const auto attributes = [](int count) {
        std::string text = "WorldBegin\nAttribute \"shape\"";
        for (int i = 0; i < count; ++i)
            text += (i == 2'000 ? "\nAttribute \"shape\" \"float r" : " \"float r") + number(i) + "\" 1";
        return text + "\n";
    };
    const raylex::Error error = error_of(attributes(4'097));
    CHECK(contains(error.message, "Attribute has set too many parameters of 'shape'; the budget parameters is 4096"));
    CHECK(error.line == 3);
    std::string text = attributes(4'000);
    for (int i = 0; i < 500; ++i) text += "Shape \"sphere\"\n";
    const auto start = std::chrono::steady_clock::now();
    CHECK(scene_of(text).shapes.size() == 500);
    // 0.5 s here; removing those unknown to spheres one by one took minutes.
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < 20);
}

TEST_CASE("the textures and materials in use are found among thousands in linear time", "[budget]") {
    std::string text = "WorldBegin\n", shapes;
    for (int i = 0; i < 30'000; ++i) {
        text += "Texture \"t" + number(i) + "\" \"spectrum\" \"constant\"\n";
        shapes += "Material \"diffuse\" \"texture reflectance\" \"t" + number(i) + "\" Shape \"sphere\"\n";
    }
    const SceneDescription scene = scene_of(text + shapes);
    const auto start = std::chrono::steady_clock::now();
    CHECK(UsedSurfaces(scene).textures().size() == 30'000);
    // 0.02 s here; comparing each name with all took 16 s.
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < 5);
}

TEST_CASE("an image with more pixels than its bytes can encode is refused before it is unpacked", "[law7][budget]") {
    const Folder folder;
    const auto be = [](unsigned value) {
        std::string bytes;
        for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
        return bytes;
    };
    const auto png_of = [&](unsigned width, unsigned height) {
        const std::string header = "IHDR" + be(width) + be(height) + std::string("\x08\0\0\0\0", 5);
        const auto checksum = static_cast<unsigned>(
            crc32(0, reinterpret_cast<const Bytef*>(header.data()), static_cast<uInt>(header.size())));
        return std::string("\x89PNG\r\n\x1a\n", 8) + be(13) + header + be(checksum) + be(0) + "IDAT" + be(0x35af061e) +
               std::string(1'000, '\0');
    };
    const std::string png = png_of(30'000, 20'000);
    // libpng would allocate a row of 2 GB before it reports the number of bytes in a row.
    CHECK(contains(message_of(read_image(folder.write("row.png", png_of(0x7fffffff, 1)))),
                   "the budget image_pixels is 268435456"));
    CHECK(contains(message_of(read_image(folder.write("a.png", png))), "the budget image_pixels is 268435456"));
    const BudgetGuard guard("image_pixels=1G");
    CHECK(contains(message_of(read_image(folder.write("a.png", png))), "the budget unpack_ratio is 100"));
    const std::string small = "IHDR" + be(8) + be(8) + std::string("\x08\0\0\0\0", 5);
    const auto small_checksum =
        static_cast<unsigned>(crc32(0, reinterpret_cast<const Bytef*>(small.data()), static_cast<uInt>(small.size())));
    const std::string chunk = std::string("\x89PNG\r\n\x1a\n", 8) + be(13) + small + be(small_checksum) +
                              be(0x3fffffff) + "IDAT" + std::string(1'000, '\0');
    CHECK(contains(message_of(read_image(folder.write("b.png", chunk))), "the file ends within a chunk"));
    const std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20000 +X 20000\n\2\2";
    CHECK(contains(message_of(read_image(folder.write("a.hdr", hdr))), "unpack_ratio"));
    CHECK(contains(message_of(read_image(folder.write("a.pfm", "PF\n50000 50000\n-1\nabcd"))),
                   "the budget image_pixels"));
    std::string tga("\0\0\x0a\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x18\0", 18);
    CHECK_FALSE(read_image(folder.write("a.tga", tga)));
}

TEST_CASE("an HDR image whose runs do not fill its lines is an error, not an endless loop", "[law7]") {
    const Folder folder;
    const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n", start("\x02\x02\x00\x08", 4);
    const std::string line = start + "\x88\x80\x88\x80\x88\x80\x88\x80";
    CHECK(read_image(folder.write("a.hdr", header + line + line)).ok());
    CHECK(read_image(folder.write("a.hdr", header + std::string(4 * 16, '\x7f'))).ok());
    const std::string damaged[] = {line,
                                   line + start,
                                   line + line.substr(0, 11),
                                   line + start + std::string(8, '\0'),
                                   line + start + "\x89\x80",
                                   std::string(60, '\x7f'),
                                   ""};
    for (const std::string& rows : damaged)
        CHECK(contains(message_of(read_image(folder.write("a.hdr", header + rows))), "HDR is truncated or damaged"));
}
