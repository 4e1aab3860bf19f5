// Textures against values worked out by hand.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "tests/transport/materials_scene.h"
#include "transport/textures/texture.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

TextureTable build_textures(const SceneDescription& scene) {
    Result<TextureTable> table = TextureTable::build(scene);
    INFO((table ? std::string() : table.error().to_string()));
    REQUIRE(table.ok());
    return *std::move(table);
}

Error build_error(const SceneDescription& scene) {
    Result<TextureTable> table = TextureTable::build(scene);
    REQUIRE_FALSE(table.ok());
    return table.error();
}

float real_at(const TextureTable& table, const std::string& name, float u, float v, const Vec3& p = {}) {
    const Result<TextureId> id = table.named_real(name, {});
    REQUIRE(id.ok());
    return table.real(*id, {u, v, p, {}, nullptr, {}});
}

Rgb colour_at(TextureTable& table, const SceneDescription& scene, const std::string& name, float u, float v,
              SpectrumRole role = SpectrumRole::albedo) {
    ParameterSet set;
    set.parameters = {texture("reflectance", name)};
    const Result<TextureId> id = table.rgb_parameter(set, "reflectance", Rgb(0), role, scene.color);
    REQUIRE(id.ok());
    return table.rgb(*id, {u, v, {}, {}, nullptr, {}});
}

/// A PFM of 2 x 2: red, green / blue, white from the top, with values that tell the texels apart. PFM rows go bottom
/// up.
class ImageFile {
  public:
    explicit ImageFile(float last = 0)
        : path_(std::filesystem::temp_directory_path() /
                ("raylex_texture_" + std::to_string(std::random_device{}()) + ".pfm")) {
        std::ofstream file(path_, std::ios::binary);
        file << "PF\n2 2\n-1.0\n";
        const float rows[] = {0, 0, 0.5f, 1, 1, 1, /* top: */ 0.25f, 0, 0, 0, 2.0f, last};
        file.write(reinterpret_cast<const char*>(rows), sizeof(rows));
    }
    ~ImageFile() { std::filesystem::remove(path_); }
    [[nodiscard]] std::string name() const { return path_.string(); }

  private:
    std::filesystem::path path_;
};

}  // namespace

TEST_CASE("constants, scale and mix compute what they say, nested too") {
    SceneDescription scene;
    scene.textures = {real_texture("constant", "half", {real("value", 0.5)}),
                      real_texture("scale", "quarter", {texture("tex", "half"), texture("scale", "half")}),
                      real_texture("mix", "blend", {real("tex1", 1), real("tex2", 3), texture("amount", "quarter")}),
                      colour_texture("constant", "red", {rgb("value", 0.8, 0.1, 0.2)}),
                      colour_texture("mix", "pink", {texture("tex1", "red"), texture("amount", "half")}),
                      colour_texture("scale", "dark", {texture("tex", "pink"), real("scale", 0.5)}),
                      real_texture("mix", "plain", {})};
    TextureTable table = build_textures(scene);
    CHECK(real_at(table, "quarter", 0, 0) == 0.25f);
    CHECK(real_at(table, "blend", 0, 0) == 1.5f);
    CHECK(real_at(table, "plain", 0, 0) == 0.5f);                   // pbrt's defaults: halfway from 0 to 1
    CHECK(colour_at(table, scene, "pink", 0, 0).r == Approx(0.9));  // tex2 defaults to white
    CHECK(colour_at(table, scene, "dark", 0, 0).g == Approx(0.275));
    CHECK(table.is_constant(*table.named_real("blend", {})));  // folded: no look-up at hits
}

TEST_CASE("the checkerboard has tex1 where both cells have one parity") {
    SceneDescription scene;
    scene.textures = {
        real_texture("checkerboard", "board",
                     {real("uscale", 4), real("vscale", 2), real("udelta", 0.5), real("tex1", 10), real("tex2", 20)}),
        real_texture("checkerboard", "default", {}),
        real_texture("checkerboard", "solid", {parameter(ParameterType::integer, "dimension", {3})})};
    scene.textures[2].to_world = Transform::translate(1, 0, 0);
    const TextureTable table = build_textures(scene);
    CHECK(real_at(table, "default", 0.5f, 0.5f) == 1);
    CHECK(real_at(table, "default", 1.5f, 0.5f) == 0);
    CHECK(real_at(table, "default", -0.5f, 0.5f) == 0);
    CHECK(real_at(table, "default", -0.5f, -0.5f) == 1);
    CHECK(real_at(table, "board", 0.1f, 0.1f) == 10);               // s = 0.9, t = 0.2
    CHECK(real_at(table, "board", 0.2f, 0.1f) == 20);               // s = 1.3
    CHECK(real_at(table, "board", 0.2f, 0.6f) == 10);               // t = 1.2
    CHECK(real_at(table, "solid", 0, 0, {1.5f, 0.5f, 0.5f}) == 1);  // (0.5, 0.5, 0.5) in the texture's space
    CHECK(real_at(table, "solid", 0, 0, {0.5f, 0.5f, 0.5f}) == 0);
    CHECK(real_at(table, "solid", 0, 0, {0.5f, 1.5f, 0.5f}) == 1);
    CHECK(real_at(table, "solid", 0, 0, {0.5f, 1.5f, -0.5f}) == 0);
}

TEST_CASE("images stand upright, interpolate between texel centres and wrap as told") {
    const ImageFile file;
    SceneDescription scene;
    const auto image = [&](const char* name, std::vector<Parameter> more) {
        more.push_back(string("filename", file.name()));
        return colour_texture("imagemap", name, std::move(more));
    };
    scene.textures = {image("repeat", {}),
                      image("clamp", {string("wrap", "clamp")}),
                      image("black", {string("wrap", "black")}),
                      image("point", {string("filter", "point")}),
                      image("inverted", {boolean("invert", true), string("wrap", "clamp")}),
                      image("scaled", {real("scale", 2), string("wrap", "clamp")}),
                      image("tiled", {real("uscale", 2), real("vdelta", 0.5), string("filter", "point")})};
    TextureTable table = build_textures(scene);
    const auto at = [&](const char* name, float u, float v) { return colour_at(table, scene, name, u, v); };
    // Texel centres: top row v = 0.75, left u = 0.25.
    CHECK(at("clamp", 0.25f, 0.75f) == Rgb(0.25f, 0, 0));
    CHECK(at("clamp", 0.75f, 0.75f) == Rgb(0, 1, 0));  // 2 as stored: an albedo is clamped
    CHECK(at("clamp", 0.25f, 0.25f) == Rgb(0, 0, 0.5f));
    CHECK(at("clamp", 0.75f, 0.25f) == Rgb(1, 1, 1));
    CHECK(colour_at(table, scene, "clamp", 0.75f, 0.75f, SpectrumRole::unbounded) == Rgb(0, 2, 0));
    const Rgb middle = at("clamp", 0.5f, 0.5f);  // mean of all four, before clamping
    CHECK(middle.r == Approx(0.3125));
    CHECK(middle.g == Approx(0.75));
    CHECK(middle.b == Approx(0.375));
    CHECK(at("clamp", -3, 9) == Rgb(0.25f, 0, 0));
    CHECK(at("repeat", 1.25f, -0.25f) == Rgb(0.25f, 0, 0));
    CHECK(at("repeat", 0, 0.75f).r == Approx(0.125));  // half of the texel on the other side
    CHECK(at("black", 0, 0.75f).r == Approx(0.125));
    CHECK(at("black", 2, 0.5f) == Rgb(0));
    CHECK(at("point", 0.4f, 0.6f) == Rgb(0.25f, 0, 0));
    CHECK(at("inverted", 0.25f, 0.75f) == Rgb(0.75f, 1, 1));
    CHECK(at("scaled", 0.25f, 0.75f) == Rgb(0.5f, 0, 0));
    CHECK(at("tiled", 0.125f, 0.25f) == Rgb(0.25f, 0, 0));  // s = 0.25, t = 0.75
    CHECK(is_finite(at("repeat", NAN, 1e30f)));
    CHECK(is_finite(at("clamp", INFINITY, -1e30f)));
}

TEST_CASE("a float texture reads the mean of an image's colours") {
    const ImageFile file;
    SceneDescription scene;
    scene.textures = {real_texture("imagemap", "mean", {string("filename", file.name()), string("wrap", "clamp")})};
    const TextureTable table = build_textures(scene);
    CHECK(real_at(table, "mean", 0.75f, 0.75f) == Approx(2.0 / 3));
    CHECK(real_at(table, "mean", 0.25f, 0.25f) == Approx(0.5 / 3));
}

TEST_CASE("nearest texels and ellipses read a float texture from the first channel, as pbrt's single texels do") {
    const ImageFile file;  // whose texel to the upper right is (0, 2, 0)
    SceneDescription scene;
    for (const char* filter : {"point", "EWA", "bilinear", "trilinear"})
        scene.textures.push_back(real_texture(
            "imagemap", filter, {string("filename", file.name()), string("wrap", "clamp"), string("filter", filter)}));
    const TextureTable table = build_textures(scene);
    const SurfaceFootprint small{{}, {}, {0.01f, 0}, {0, 0.01f}};
    const auto value = [&](const char* filter, const SurfaceFootprint* footprint) {
        const Result<TextureId> id = table.named_real(filter, {});
        REQUIRE(id.ok());
        return table.real(*id, {0.75f, 0.75f, {}, {}, footprint, {}});
    };
    for (const SurfaceFootprint* footprint : {static_cast<const SurfaceFootprint*>(nullptr), &small}) {
        CHECK(value("point", footprint) == 0);
        CHECK(value("bilinear", footprint) == Approx(2.0 / 3));
        CHECK(value("trilinear", footprint) == Approx(2.0 / 3));
    }
    CHECK(value("EWA", nullptr) == Approx(2.0 / 3));  // as bilinear
    // Its ellipse of a texel around the middle of one takes in the others: red is 0, 0.25, 1 and 0 in the four.
    CHECK(value("EWA", &small) < 0.35f);
}

TEST_CASE("a constant scale over an image is the image's own, before it is inverted and limited") {
    const ImageFile file;  // (0.25, 0, 0) at the upper left, (0, 2, 0) beside it, (0, 0, 0.5) below
    const Parameter name = string("filename", file.name()), clamp = string("wrap", "clamp");
    const auto scaled = [](const char* called, const char* of, float by) {
        return colour_texture("scale", called, {texture("tex", of), real("scale", by)});
    };
    SceneDescription scene;
    scene.textures = {colour_texture("imagemap", "image", {name, clamp}),
                      colour_texture("imagemap", "inverted", {name, clamp, boolean("invert", true)}),
                      scaled("up", "image", 3),
                      scaled("down", "up", 0.5f),
                      scaled("once", "image", 1),
                      scaled("of inverted", "inverted", 0.5f),
                      real_texture("imagemap", "number", {name, clamp, boolean("invert", true)}),
                      real_texture("constant", "half", {real("value", 0.5f)}),
                      real_texture("scale", "exchanged", {texture("scale", "number"), texture("tex", "half")}),
                      colour_texture("scale", "by image", {texture("tex", "image"), texture("scale", "number")})};
    TextureTable table = build_textures(scene);
    const auto at = [&](const char* called, float u, float v) { return colour_at(table, scene, called, u, v); };
    CHECK(at("up", 0.25f, 0.75f) == Rgb(0.75f, 0, 0));
    CHECK(at("up", 0.25f, 0.25f) == Rgb(0, 0, 1));
    CHECK(at("down", 0.25f, 0.25f) == Rgb(0, 0, 0.75f));  // 0.5 x 3 x 0.5, limited at the end alone
    CHECK(at("once", 0.75f, 0.75f) == Rgb(0, 1, 0));
    CHECK(at("of inverted", 0.25f, 0.75f) == Rgb(0.875f, 1, 1));
    CHECK(real_at(table, "exchanged", 0.75f, 0.75f) == Approx(1 - 0.5 * 2.0 / 3));
    CHECK(at("by image", 0.25f, 0.75f).r == Approx(0.25 * (1 - 0.25 / 3)));  // no constant: both as they are
}

TEST_CASE("an unknown filter is taken for EWA with a warning, as pbrt goes on") {
    const ImageFile file;
    SceneDescription scene;
    scene.textures = {colour_texture("imagemap", "x", {string("filename", file.name()), string("filter", "none")})};
    TextureTable table = build_textures(scene);
    static_cast<void>(colour_at(table, scene, "x", 0.5f, 0.5f));
    REQUIRE(table.warnings().size() == 1);
    CHECK(table.warnings()[0].message ==
          "'filter' is 'none'; expected bilinear, point, trilinear, EWA or unfiltered. EWA is used");
}

TEST_CASE("texels that are no numbers are reported with their place and taken as 0") {
    for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const ImageFile file(value);
        SceneDescription scene;
        scene.file = "scene.pbrt";
        scene.textures = {colour_texture("imagemap", "picture", {string("filename", file.name())})};
        scene.textures[0].location = {"scene.pbrt", 5, 1};
        TextureTable table = build_textures(scene);
        REQUIRE(table.warnings().size() == 1);
        CHECK(table.warnings()[0].file == "scene.pbrt");
        CHECK(table.warnings()[0].message.find("1 value in 1 texel not finite, first at column 1, row 0; taken as 0") !=
              std::string::npos);
        CHECK(colour_at(table, scene, "picture", 0.75f, 0.75f) == Rgb(0, 1, 0));  // albedos end at 1
    }
    const ImageFile clean;
    SceneDescription scene;
    scene.textures = {colour_texture("imagemap", "picture", {string("filename", clean.name())})};
    CHECK(build_textures(scene).warnings().empty());
}

TEST_CASE("negative texels are numbers to float textures, and no colours") {
    const ImageFile file(-0.5f);
    SceneDescription scene;
    scene.textures = {colour_texture("imagemap", "picture", {string("filename", file.name()), string("wrap", "clamp")}),
                      real_texture("imagemap", "height", {string("filename", file.name()), string("wrap", "clamp")})};
    TextureTable table = build_textures(scene);
    CHECK(table.warnings().empty());
    CHECK(real_at(table, "height", 0.75f, 0.75f) == Approx(0.5));  // the mean of 0, 2 and -0.5
    CHECK(colour_at(table, scene, "picture", 0.75f, 0.75f) == Rgb(0, 1, 0));
    CHECK(colour_at(table, scene, "picture", 0.75f, 0.75f, SpectrumRole::unbounded) == Rgb(0, 2, 0));
}

TEST_CASE("colour images are taken to the rendering space, unbounded ones are not") {
    const ImageFile file;
    SceneDescription scene;
    scene.textures = {colour_texture("imagemap", "image", {string("filename", file.name()), string("wrap", "clamp")})};
    scene.color.rendering_from_scene = {{{0.5, 0.5, 0}, {0, 1, 0}, {0, 0, 0.5}}};
    TextureTable table = build_textures(scene);
    CHECK(colour_at(table, scene, "image", 0.25f, 0.75f) == Rgb(0.125f, 0, 0));
    CHECK(colour_at(table, scene, "image", 0.25f, 0.25f) == Rgb(0, 0, 0.25f));
    CHECK(colour_at(table, scene, "image", 0.25f, 0.75f, SpectrumRole::unbounded) == Rgb(0.25f, 0, 0));
}

TEST_CASE("images may be defined after those that use them, and numbers after colours, as pbrt makes textures") {
    const ImageFile file;
    SceneDescription scene;
    scene.textures = {colour_texture("scale", "tinted", {texture("tex", "image"), texture("scale", "half")}),
                      colour_texture("imagemap", "image", {string("filename", file.name()), string("wrap", "clamp")}),
                      real_texture("scale", "early", {texture("tex", "number")}),
                      real_texture("constant", "half", {real("value", 0.5)}),
                      real_texture("imagemap", "number", {string("filename", file.name()), string("wrap", "clamp")})};
    TextureTable table = build_textures(scene);
    CHECK(colour_at(table, scene, "tinted", 0.25f, 0.25f) == Rgb(0, 0, 0.25f));
    CHECK(real_at(table, "early", 0.25f, 0.25f) == Approx(0.5 / 3));
    scene.textures[2].parameters.parameters = {texture("tex", "half")};  // neither: it is further down
    CHECK(build_error(scene).hint.find("further down") != std::string::npos);
}

TEST_CASE("mappings place texture space on the surface") {
    SceneDescription scene;
    const auto board = [](const char* name, std::vector<Parameter> more) {
        return real_texture("checkerboard", name, std::move(more));
    };
    scene.textures = {
        board("planar",
              {string("mapping", "planar"), parameter(ParameterType::vector3, "v1", {0, 0, 1}), real("udelta", 1)}),
        board("spherical", {string("mapping", "spherical")}), board("cylindrical", {string("mapping", "cylindrical")})};
    scene.textures[0].to_world = Transform::scale(2, 2, 2);
    const TextureTable table = build_textures(scene);
    CHECK(real_at(table, "planar", 0, 0, {0, 1, 1}) == 0);            // s = 0.5 + 1, t = 0.5
    CHECK(real_at(table, "planar", 0, 0, {0, 3, 1}) == 1);            // t = 1.5
    CHECK(real_at(table, "spherical", 0, 0, {0.3f, 0.2f, -5}) == 1);  // both coordinates within [0, 1)
    CHECK(real_at(table, "cylindrical", 0, 0, {1, 1, 0.5f}) == 1);
    CHECK(real_at(table, "cylindrical", 0, 0, {1, 1, 1.5f}) == 0);
}

TEST_CASE("a mapping of an unknown name is by u and v, as in pbrt, and said once") {
    SceneDescription scene;
    scene.textures = {colour_texture("checkerboard", "board", {string("mapping", "planer"), real("uscale", 2)}),
                      colour_texture("checkerboard", "known", {real("uscale", 2)})};
    TextureTable table = build_textures(scene);
    for (const float u : {0.2f, 0.7f, 1.2f})
        for (const SpectrumRole role : {SpectrumRole::albedo, SpectrumRole::unbounded})
            CHECK(colour_at(table, scene, "board", u, 0.5f, role) == colour_at(table, scene, "known", u, 0.5f, role));
    REQUIRE(table.warnings().size() == 1);
    const Error& warning = table.warnings()[0];
    CHECK(warning.message.find("'mapping' is 'planer'; expected uv, spherical, cylindrical or planar. It is read "
                               "as uv") != std::string::npos);
    CHECK(warning.hint == "did you mean 'planar'?");
    CHECK(warning.line == 7);
}

TEST_CASE("mistakes in textures are located and name what was expected") {
    SceneDescription scene;
    const auto only = [&](SceneTexture t) {
        scene.textures = {real_texture("constant", "known", {}), std::move(t)};
        return build_error(scene);
    };
    Error e = only(real_texture("checkboard", "x", {}));
    CHECK(e.line == 5);
    CHECK(e.hint == "did you mean 'checkerboard'?");
    e = only(real_texture("scale", "x", {texture("tex", "knwon")}));
    CHECK((e.line == 7 && e.column == 3 && e.file == "scene.pbrt"));
    CHECK(e.hint == "did you mean 'known'?");
    e = only(colour_texture("scale", "x", {texture("tex", "known")}));
    CHECK(e.hint == "there is a float texture of that name");
    e = only(real_texture("scale", "x", {texture("tex", "x")}));
    CHECK(e.hint.find("further down") != std::string::npos);
    e = only(real_texture("imagemap", "x", {string("filename", "no-such-file.png")}));
    CHECK(e.line == 7);
    CHECK(e.message.find("no-such-file.png") != std::string::npos);
    e = only(real_texture("imagemap", "x", {}));
    CHECK(e.message.find("filename") != std::string::npos);
    e = only(real_texture("imagemap", "x", {string("filename", "f.png"), string("wrap", "mirror")}));
    CHECK(e.message.find("octahedralsphere") != std::string::npos);
    e = only(real_texture("checkerboard", "x", {parameter(ParameterType::integer, "dimension", {4})}));
    CHECK(e.message.find("2 to 3") != std::string::npos);
    scene.textures = {real_texture("constant", "known", {})};
    const Result<TextureId> missing = build_textures(scene).named_real("leaf", {"scene.pbrt", 9, 1});
    REQUIRE_FALSE(missing.ok());
    CHECK(missing.error().line == 9);
}
