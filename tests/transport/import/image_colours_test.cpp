// The colour space of image files: its declaration in OpenEXR files, and its use in lights and textures.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "tests/display/files.h"
#include "tests/transport/import_support.h"
#include "tests/transport/lit_scene.h"
#include "tests/transport/materials_scene.h"
#include "transport/files/images/image.h"
#include "transport/textures/image_mean.h"
#include "transport/textures/texture.h"

using namespace raylex;
using namespace raylex::transport;

namespace image_colours {

const Imf::Chromaticities aces({.7347f, .2653f}, {0, 1}, {.0001f, -.077f}, {.32168f, .33767f}),
    rec2020({.708f, .292f}, {.17f, .797f}, {.131f, .046f}, {.3127f, .329f}),
    p3({.68f, .32f}, {.265f, .69f}, {.15f, .06f}, {.3127f, .329f}),
    acescg({.713f, .293f}, {.165f, .83f}, {.128f, .044f}, {.32168f, .33767f});

/// 2 x 2 pixels of one colour.
std::string write(const raylex::test::Folder& folder, const std::string& name, const Rgb& colour,
                  const Imf::Chromaticities* chromaticities) {
    const auto plane = [](Real value) { return std::vector<float>(4, to_float(value)); };
    const auto box = raylex::test::box(2, 2);
    const std::string path = folder.path(name);
    raylex::test::write_foreign(
        path,
        {{"R", Imf::FLOAT, plane(colour.r)}, {"G", Imf::FLOAT, plane(colour.g)}, {"B", Imf::FLOAT, plane(colour.b)}},
        box, box, 0, chromaticities);
    return path;
}

Rgb sky(const std::string& file, const std::string& space) {
    const Lit scene = lit("LightSource \"infinite\" \"string filename\" \"" + file + "\" Shape \"sphere\"",
                          "ColorSpace \"" + space + "\" Film \"rgb\" ");
    return scene.lights.environment_radiance(0, {}, {0, 0, 1});
}

Rgb texture_colour(const std::string& file, ColorSpace space, SpectrumRole role) {
    SceneDescription scene;
    scene.color.scene_space = space;
    scene.textures = {raylex::test::colour_texture("imagemap", "image", {raylex::test::string("filename", file)})};
    auto table = TextureTable::build(scene);
    REQUIRE(table.ok());
    ParameterSet set;
    set.parameters = {raylex::test::texture("reflectance", "image")};
    const auto id = table->rgb_parameter(set, "reflectance", Rgb(0), role, scene.color);
    REQUIRE(id.ok());
    return table->rgb(*id, {0.5f, 0.5f, {}, {}, nullptr, {}});
}

/// Expected values use matrices from the chromaticities above. raylex integrates the whites' spectra, whose
/// chromaticities are those rounded to four digits: 2e-4 of a colour.
void check_colour(const Rgb& found, const Rgb& expected) {
    CAPTURE(found.r, found.g, found.b);
    for (int c = 0; c < 3; ++c) CHECK(std::abs(found[c] - expected[c]) < Real(1e-3) * expected.max());
}

}  // namespace image_colours

using namespace image_colours;

TEST_CASE("an OpenEXR image declares the space of its colours", "[image]") {
    const raylex::test::Folder folder;
    const auto space_of = [&](const char* name, const Imf::Chromaticities* chromaticities) {
        const auto image = read_image(write(folder, name, Rgb(1), chromaticities));
        REQUIRE(image.ok());
        CHECK(image->warning.empty());
        return image->space;
    };
    const Imf::Chromaticities srgb;
    CHECK(space_of("none.exr", nullptr) == ColorSpace::srgb);
    CHECK(space_of("srgb.exr", &srgb) == ColorSpace::srgb);
    CHECK(space_of("p3.exr", &p3) == ColorSpace::dci_p3);
    CHECK(space_of("rec2020.exr", &rec2020) == ColorSpace::rec2020);
    CHECK(space_of("aces.exr", &aces) == ColorSpace::aces2065_1);
    const auto other = read_image(write(folder, "acescg.exr", Rgb(1), &acescg));
    REQUIRE(other.ok());
    CHECK(other->space == ColorSpace::srgb);
    CHECK(other->other_space);
    const Lit warned =
        lit("LightSource \"infinite\" \"string filename\" \"" + folder.path("acescg.exr") + "\" Shape \"sphere\"");
    REQUIRE(warned.warnings.size() == 1);
    CHECK(warned.warnings[0].message.find("taken as sRGB") != std::string::npos);
}

TEST_CASE("an unknown space gives a warning only where colours are used", "[image]") {
    const raylex::test::Folder folder;
    const std::string file = write(folder, "acescg.exr", Rgb(1), &acescg);
    const auto warnings = [](SceneTexture texture) {
        SceneDescription scene;
        scene.textures = {std::move(texture)};
        auto table = TextureTable::build(scene);
        REQUIRE(table.ok());
        if (!scene.textures[0].spectrum) REQUIRE(table->named_real("image", {}).ok());
        return table->warnings();
    };
    const auto colour =
        warnings(raylex::test::colour_texture("imagemap", "image", {raylex::test::string("filename", file)}));
    REQUIRE(colour.size() == 1);
    CHECK(colour[0].message.find("taken as sRGB") != std::string::npos);
    CHECK(warnings(raylex::test::real_texture("imagemap", "image", {raylex::test::string("filename", file)})).empty());
    CHECK(lit("LightSource \"goniometric\" \"string filename\" \"" + file + "\" Shape \"sphere\"").warnings.empty());
}

TEST_CASE("a light without a colour emits the white of its own colour space", "[import][lights]") {
    const auto emission = [](const std::string& film, const std::string& block, const std::string& light) {
        const Lit scene = lit("AttributeBegin ColorSpace \"" + block + "\" " + light + " AttributeEnd Shape \"sphere\"",
                              "ColorSpace \"" + film + "\" Film \"rgb\" ");
        return scene.lights.lights()[0].emission;
    };
    // D60 at Y = 1 in sRGB, and D65 in ACES2065-1, by the chromaticities above.
    const std::string area = "AreaLightSource \"diffuse\" Shape \"disk\"";
    for (const std::string& light :
         {std::string("LightSource \"point\""), std::string("LightSource \"infinite\""), area})
        check_colour(emission("srgb", "aces2065-1", light), Rgb(Real(1.0465), Real(0.9950), Real(0.9155)));
    check_colour(emission("aces2065-1", "srgb", "LightSource \"spot\""), Rgb(Real(0.9983), Real(1.0089), Real(1.0798)));
    CHECK(emission("rec2020", "rec2020", area) == Rgb(1));
    const raylex::test::Folder folder;
    const std::string file = write(folder, "sky.exr", Rgb(2), &rec2020);
    const Lit image = lit("AttributeBegin ColorSpace \"aces2065-1\" LightSource \"infinite\" \"string filename\" \"" +
                              file + "\" AttributeEnd Shape \"sphere\"",
                          "Film \"rgb\" ");  // "L" is not added beside a file
    check_colour(image.lights.environment_radiance(0, {}, {0, 0, 1}), Rgb(2));
    const Lit by_attribute = lit("AttributeBegin ColorSpace \"aces2065-1\" Attribute \"light\" \"string filename\" \"" +
                                     file + "\" LightSource \"infinite\" AttributeEnd Shape \"sphere\"",
                                 "Film \"rgb\" ");
    check_colour(by_attribute.lights.environment_radiance(0, {}, {0, 0, 1}), Rgb(2));
}

TEST_CASE("the mean that replaces an image has its colour and its sign", "[image][effects]") {
    const raylex::test::Folder folder;
    const std::string wall = write(folder, "wall.exr", {Real(.5), Real(.4), Real(.3)}, &aces),
                      pit = write(folder, "pit.exr", {Real(-1), Real(-2), Real(-3)}, nullptr);
    const ColorContext color;
    const auto mean = mean_of_image(
        raylex::test::colour_texture("imagemap", "wall", {raylex::test::string("filename", wall)}), color);
    REQUIRE(mean.ok());
    const Rgb shown = texture_colour(wall, ColorSpace::srgb, SpectrumRole::albedo);
    for (std::size_t c = 0; c < 3; ++c)  // a constant image equals its mean, to a rounding of float
        CHECK(mean->at(c) == Approx(static_cast<double>(shown[static_cast<int>(c)])).epsilon(1e-6));
    const auto depth =
        mean_of_image(raylex::test::real_texture("imagemap", "pit", {raylex::test::string("filename", pit)}), color);
    REQUIRE(depth.ok());
    CHECK(depth->at(0) == Approx(-2));
}

TEST_CASE("light of an image keeps its colour in every scene space, and an albedo keeps its grey", "[image][lights]") {
    const raylex::test::Folder folder;
    const std::string file = write(folder, "aces.exr", {Real(.5), Real(.2), Real(.1)}, &aces),
                      white = write(folder, "white.exr", Rgb(1), &aces),
                      plain = write(folder, "plain.exr", {Real(.5776), Real(.127), Real(.032)}, nullptr),
                      wall = write(folder, "wall.exr", {Real(.5), Real(.4), Real(.3)}, &aces);
    check_colour(sky(file, "srgb"), {Real(1.01612), Real(.12486), Real(.06981)});
    check_colour(sky(white, "srgb"), {Real(1.04710), Real(.99454), Real(.91532)});
    check_colour(sky(plain, "rec2020"), {Real(.40559), Real(.15706), Real(.04930)});
    CHECK(sky(file, "aces2065-1") == Rgb(Real(.5), Real(.2), Real(.1)));
    CHECK(sky(plain, "srgb") == Rgb(Real(.5776), Real(.127), Real(.032)));
    check_colour(texture_colour(white, ColorSpace::srgb, SpectrumRole::albedo), Rgb(1));
    check_colour(texture_colour(wall, ColorSpace::srgb, SpectrumRole::albedo),
                 {Real(.69831), Real(.38143), Real(.28169)});
    CHECK(texture_colour(wall, ColorSpace::srgb, SpectrumRole::unbounded) == Rgb(Real(.5), Real(.4), Real(.3)));
    CHECK(texture_colour(wall, ColorSpace::aces2065_1, SpectrumRole::albedo) == Rgb(Real(.5), Real(.4), Real(.3)));
}

TEST_CASE("a goniometric light averages values as they are stored", "[image][lights]") {
    const raylex::test::Folder folder;
    const auto radiance = [&](const Imf::Chromaticities* chromaticities) {
        const std::string file = write(folder, chromaticities == nullptr ? "a.exr" : "b.exr",
                                       {Real(.5), Real(.2), Real(.1)}, chromaticities);
        return lit("LightSource \"goniometric\" \"string filename\" \"" + file + "\" Shape \"sphere\"")
            .lights.lights()[0]
            .power;
    };
    CHECK(radiance(nullptr) == radiance(&aces));
}
