#include "display/output/color/color_manager.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <OpenColorIO/OpenColorIO.h>

#include "display/output/color/primaries.h"
#include "files.h"
#include "tests/support/paths.h"

using raylex::display::Chromaticities;
using raylex::display::ColorManager;
using raylex::test::Folder;

namespace {

// The tests must not depend on their environment.
struct WithoutOcio {
    WithoutOcio() {
        if (const char* value = std::getenv("OCIO")) {
            saved = value;
            had = true;
        }
        unsetenv("OCIO");
    }
    ~WithoutOcio() {
        if (had) setenv("OCIO", saved.c_str(), 1);
        else unsetenv("OCIO");
    }
    std::string saved;
    bool had = false;
};

ColorManager shipped() {
    auto manager = ColorManager::open();
    REQUIRE(manager.ok());
    return std::move(*manager);
}

const std::string shipped_path = raylex::test::source_dir() + "/display/ocio/raylex.ocio";

std::vector<unsigned char> show(const ColorManager& manager, const std::vector<float>& rgb,
                                const Chromaticities& primaries, const std::string& view) {
    auto shown = manager.to_display(rgb, primaries, "", view);
    REQUIRE(shown.ok());
    return *shown;
}

}  // namespace

TEST_CASE("the shipped config is valid and is found without any environment", "[display][ocio]") {
    const WithoutOcio environment;
    namespace ocio = OCIO_NAMESPACE;
    REQUIRE_NOTHROW(ocio::Config::CreateFromFile(shipped_path.c_str())->validate());
    const ColorManager manager = shipped();
    CHECK(manager.default_display() == "sRGB - Display");
    CHECK(manager.default_view("") == "ACES 1.0 - SDR Video");
    const auto views = manager.views("sRGB - Display");
    CHECK(std::find(views.begin(), views.end(), "Un-tone-mapped") != views.end());
    CHECK(std::find(views.begin(), views.end(), "Raw") != views.end());
    CHECK(manager.scene_linear_spaces() ==
          std::vector<std::string>{"ACES2065-1", "ACEScg", "lin_rec709", "lin_rec2020", "lin_p3d65"});
    CHECK(manager.displays().size() == 5);
}

TEST_CASE("the shipped config gives the figures of OpenColorIO's ACES transforms", "[display][ocio]") {
    // Reference values, computed once with OpenColorIO 2.1.2 from its builtin transforms, to five digits.
    namespace ocio = OCIO_NAMESPACE;
    const auto config = ocio::Config::CreateFromFile(shipped_path.c_str());
    const auto grey = [&config](const char* source, const char* view, float value) {
        const auto transform = ocio::DisplayViewTransform::Create();
        transform->setSrc(source);
        transform->setDisplay("sRGB - Display");
        transform->setView(view);
        float rgb[3] = {value, value, value};
        config->getProcessor(transform)->getDefaultCPUProcessor()->applyRGB(rgb);
        return rgb[1];
    };
    CHECK(grey("ACEScg", "ACES 1.0 - SDR Video", 0.18f) == Approx(0.35595).margin(5e-6));
    CHECK(grey("lin_rec709", "Un-tone-mapped", 0.5f) == Approx(0.73536).margin(5e-6));

    const WithoutOcio environment;
    const auto matrix = shipped().matrix_to("ACEScg", raylex::display::rec709_primaries());
    REQUIRE(matrix.ok());
    // The reference has six digits.
    CHECK((*matrix)[0][0] == Approx(0.613097).margin(1e-6));
    CHECK((*matrix)[1][0] == Approx(0.070194).margin(1e-6));
    CHECK((*matrix)[2][0] == Approx(0.020616).margin(1e-6));
}

TEST_CASE("file rules of the shipped config distinguish 8-bit and float images", "[display][ocio]") {
    const auto config = OCIO_NAMESPACE::Config::CreateFromFile(shipped_path.c_str());
    const auto space = [&config](const char* file) { return std::string(config->getColorSpaceFromFilepath(file)); };
    CHECK(space("wood.png") == "srgb_texture");
    CHECK(space("dir.exr/WOOD.JPEG") == "srgb_texture");
    CHECK(space("wood.tga") == "srgb_texture");
    CHECK(space("sky.hdr") == "lin_rec709");
    CHECK(space("render.0001.exr") == "lin_rec709");
    CHECK(space("sky_ACEScg.exr") == "ACEScg");
    CHECK(space("plate_ap0.exr") == "ACES2065-1");
    CHECK(space("weights.bin") == "Raw");
}

TEST_CASE("file rules convert stored texels to linear values with the requested primaries", "[display][ocio]") {
    const WithoutOcio environment;
    const ColorManager manager = shipped();
    const auto converted = [&](const char* file, std::vector<float> rgb, const Chromaticities& to) {
        const auto color = manager.file_color(file, to);
        REQUIRE(color.ok());
        color->convert(rgb);
        return rgb;
    };
    const Chromaticities rec709 = raylex::display::rec709_primaries();
    // IEC 61966-2-1: 0.5 decodes to ((0.5 + 0.055) / 1.055)^2.4. OpenColorIO computes in float.
    const double decoded = std::pow((0.5 + 0.055) / 1.055, 2.4);
    const auto png = converted("wood.png", {0.5f, 0.0f, 1.0f}, rec709);
    CHECK(png[0] == Approx(decoded).epsilon(1e-5));
    CHECK(png[1] == Approx(0).margin(1e-6));
    CHECK(png[2] == Approx(1).epsilon(1e-5));
    const auto exr = converted("sky.exr", {0.5f, 7.0f, 1e-3f}, rec709);
    CHECK(exr[0] == Approx(0.5).epsilon(1e-5));
    CHECK(exr[1] == Approx(7).epsilon(1e-5));
    const auto expected = raylex::display::transform_colour(
        raylex::display::rgb_to_rgb(raylex::display::aces_ap1_primaries(), rec709), {0.2, 0.5, 0.1});
    const auto cg = converted("sky_ACEScg.exr", {0.2f, 0.5f, 0.1f}, rec709);
    for (std::size_t c = 0; c < 3; ++c) CHECK(cg[c] == Approx(expected[c]).epsilon(1e-5));

    // Data values are unchanged, but never become light that is not finite (Law 6).
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    CHECK(converted("weights.bin", {0.5f, nan, -2.0f}, rec709) == std::vector<float>{0.5f, 0.0f, -2.0f});
    for (const float value : converted("sky.exr", {nan, inf, -inf}, rec709)) CHECK(value == Approx(0).margin(1e-6));
    CHECK(manager.file_color("weights.bin", rec709)->by_default);
    CHECK(manager.file_color("weights.bin", rec709)->is_data);
    CHECK(!manager.file_color("wood.png", rec709)->by_default);
    CHECK(manager.warnings().empty());
}

TEST_CASE("a file rule that can never match gives a warning", "[display][ocio]") {
    const WithoutOcio environment;
    const Folder folder;
    std::string text = raylex::test::read_bytes(shipped_path);
    const std::string rule = "file_rules:\n";
    const std::size_t at = text.find(rule);
    REQUIRE(at != std::string::npos);
    text.insert(at + rule.size(),
                "  - !<Rule> {name: pictures, colorspace: Raw, pattern: \"*\", extension: \"(png|jpe?g)\"}\n");
    raylex::test::write_bytes(folder.path("trap.ocio"), text);
    const auto manager = ColorManager::open(folder.path("trap.ocio"));
    REQUIRE(manager.ok());
    REQUIRE(manager->warnings().size() == 1);
    CHECK(manager->warnings()[0].find("'pictures'") != std::string::npos);
    CHECK(manager->warnings()[0].find("'(png|jpe?g)', which is a glob") != std::string::npos);
    CHECK(manager->file_color("wood.png", raylex::display::rec709_primaries())->space ==
          "srgb_texture");  // no rule matches
}

TEST_CASE("conversions between a config's spaces and chromaticities agree with the primaries' own matrices",
          "[display][ocio]") {
    const WithoutOcio environment;
    const ColorManager manager = shipped();
    for (const std::string& space : manager.scene_linear_spaces()) {
        CAPTURE(space);
        const auto primaries = manager.chromaticities(space);
        REQUIRE(primaries.ok());
        const auto identity = manager.matrix_to(space, *primaries);
        REQUIRE(identity.ok());
        CHECK(*identity == raylex::display::identity_matrix());  // exactly: equal spaces must change no bit
        const auto from_p3 = manager.matrix_to(space, raylex::display::p3d65_primaries());
        const auto expected = raylex::display::rgb_to_rgb(raylex::display::p3d65_primaries(), *primaries);
        REQUIRE(from_p3.ok());
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                CHECK((*from_p3)[i][j] == Approx(expected[i][j]).margin(2e-6));  // OpenColorIO computes in float
    }
    CHECK(raylex::display::equivalent(*manager.chromaticities("ACEScg"), raylex::display::aces_ap1_primaries()));
    CHECK(raylex::display::equivalent(*manager.chromaticities("scene_linear"),
                                      raylex::display::aces_ap1_primaries()));  // a role
}

TEST_CASE("a preview shows grey as the view defines it, whatever the primaries", "[display][ocio]") {
    const WithoutOcio environment;
    const ColorManager manager = shipped();
    const std::vector<float> grey{0.18f, 0.18f, 0.18f};
    // .35595 x 255 = 90.77; grey in any space with its own white is grey on the display.
    const std::vector<unsigned char> expected{91, 91, 91};
    CHECK(show(manager, grey, raylex::display::aces_ap1_primaries(), "") == expected);
    CHECK(show(manager, grey, raylex::display::rec709_primaries(), "") == expected);
    CHECK(show(manager, {0.5f, 0.5f, 0.5f}, raylex::display::rec709_primaries(), "Un-tone-mapped") ==
          std::vector<unsigned char>{188, 188, 188});
    // Rec. 709 red is the display's own red and in gamut. As AP1 primaries the same numbers are clipped.
    CHECK(show(manager, {1, 0, 0}, raylex::display::rec709_primaries(), "Un-tone-mapped") ==
          std::vector<unsigned char>{255, 0, 0});
    CHECK(show(manager, {0.5f, 0.25f, 0.1f}, raylex::display::aces_ap1_primaries(), "Un-tone-mapped") !=
          show(manager, {0.5f, 0.25f, 0.1f}, raylex::display::rec709_primaries(), "Un-tone-mapped"));
    // Raw shows the file's own numbers: no matrix, no curve.
    CHECK(show(manager, {1.0f, 0.2f, 0.0f}, raylex::display::aces_ap1_primaries(), "Raw") ==
          std::vector<unsigned char>{255, 51, 0});
}

TEST_CASE("values that no view can show do not spoil a preview", "[display][ocio][law6]") {
    const WithoutOcio environment;
    const ColorManager manager = shipped();
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const char* view : {"ACES 1.0 - SDR Video", "Un-tone-mapped", "Raw"}) {
        CAPTURE(view);
        const auto shown =
            show(manager, {nan, nan, nan, inf, inf, inf, -inf, -inf, -inf, 3e38f, 3e38f, 3e38f, 0, 0, 0}, {}, view);
        CHECK(std::vector(shown.begin(), shown.begin() + 9) == std::vector<unsigned char>(9, 0));
        CHECK(std::vector(shown.begin() + 9, shown.begin() + 12) == std::vector<unsigned char>{255, 255, 255});
        CHECK(std::vector(shown.begin() + 12, shown.end()) == std::vector<unsigned char>(3, 0));
    }
}

TEST_CASE("a preview has the same bytes for any number of threads and strips", "[display][ocio]") {
    const WithoutOcio environment;
    const ColorManager manager = shipped();
    std::vector<float> rgb;
    for (int i = 0; i < 150'001; ++i)
        rgb.insert(rgb.end(), {0.00001f * static_cast<float>(i), 0.3f, 1.0f - 0.000005f * static_cast<float>(i)});
    const auto whole = show(manager, rgb, {}, "");
    REQUIRE(whole.size() == rgb.size());
    for (const std::size_t pixel : {0u, 4095u, 4096u, 74'999u, 75'000u, 150'000u}) {
        const std::vector<float> one(rgb.begin() + static_cast<std::ptrdiff_t>(pixel * 3),
                                     rgb.begin() + static_cast<std::ptrdiff_t>(pixel * 3 + 3));
        const auto alone = show(manager, one, {}, "");
        CHECK(std::equal(alone.begin(), alone.end(), whole.begin() + static_cast<std::ptrdiff_t>(pixel * 3)));
    }
}

TEST_CASE("an option overrides $OCIO, which overrides the shipped config", "[display][ocio]") {
    const WithoutOcio environment;
    const Folder folder;
    const std::string text = raylex::test::read_bytes(shipped_path);
    const auto renamed = [&text](const std::string& name) {
        std::string copy = text;
        const std::string from = "name: raylex-aces-1";
        return copy.replace(copy.find(from), from.size(), "name: " + name);
    };
    raylex::test::write_bytes(folder.path("a.ocio"), renamed("from-option"));
    raylex::test::write_bytes(folder.path("b.ocio"), renamed("from-environment"));
    CHECK(shipped().description() == "the config shipped with raylex (raylex-aces-1)");
    setenv("OCIO", folder.path("b.ocio").c_str(), 1);
    CHECK(shipped().description() == folder.path("b.ocio") + " (from-environment)");
    CHECK(ColorManager::open(folder.path("a.ocio"))->description() == folder.path("a.ocio") + " (from-option)");
    setenv("OCIO", "", 1);
    CHECK(shipped().description() == "the config shipped with raylex (raylex-aces-1)");
}

TEST_CASE("bad configs, spaces, displays and views get errors that name them", "[display][ocio][law7]") {
    const WithoutOcio environment;
    const Folder folder;
    const std::string missing = folder.path("missing.ocio");
    auto absent = ColorManager::open(missing);
    REQUIRE(!absent.ok());
    CHECK(absent.error().file == missing);
    CHECK(absent.error().message.find("cannot read the OpenColorIO config") != std::string::npos);

    raylex::test::write_bytes(folder.path("bad.ocio"), "ocio_profile_version: 2.1\nroles: [unclosed\n");
    setenv("OCIO", folder.path("bad.ocio").c_str(), 1);
    auto bad = ColorManager::open();
    REQUIRE(!bad.ok());
    CHECK(bad.error().file == folder.path("bad.ocio"));
    CHECK(bad.error().message.find("$OCIO") != std::string::npos);
    unsetenv("OCIO");
    auto directory = ColorManager::open(folder.path());
    REQUIRE(!directory.ok());
    CHECK(directory.error().message.find("this is a directory") != std::string::npos);

    const ColorManager manager = shipped();
    const auto space = manager.matrix_to("ACESgc", {});
    REQUIRE(!space.ok());
    CHECK(space.error().hint.find("ACEScg") != std::string::npos);
    CHECK(space.error().message.find("lin_rec709") != std::string::npos);
    CHECK(!manager.matrix_to("srgb_texture", {}).ok());
    CHECK(!manager.matrix_to("Raw", {}).ok());
    CHECK(!manager.chromaticities("sRGB - Display").ok());
    const std::vector<float> pixel(3, 0.5f);
    const auto display = manager.to_display(pixel, {}, "sRGB", "");
    REQUIRE(!display.ok());
    CHECK(display.error().message.find("no display 'sRGB'") != std::string::npos);
    const auto view = manager.to_display(pixel, {}, "", "Film");
    REQUIRE(!view.ok());
    CHECK(view.error().message.find("'Film'") != std::string::npos);
}

TEST_CASE("a version 1 config without interchange roles is assumed to be Rec. 709, and the description says so",
          "[display][ocio]") {
    const WithoutOcio environment;
    const Folder folder;
    raylex::test::write_bytes(folder.path("old.ocio"), R"(ocio_profile_version: 1
search_path: ""
roles:
  default: linear
  scene_linear: linear
displays:
  default:
    - !<View> {name: Film, colorspace: gamma}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: linear
    isdata: false
    allocation: uniform
  - !<ColorSpace>
    name: gamma
    isdata: false
    allocation: uniform
    to_reference: !<ExponentTransform> {value: [2, 2, 2, 1]}
  - !<ColorSpace>
    name: doubled
    isdata: false
    allocation: uniform
    to_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
)");
    auto manager = ColorManager::open(folder.path("old.ocio"));
    REQUIRE(manager.ok());
    CHECK(manager->description().find("Rec. 709") != std::string::npos);
    CHECK(manager->scene_linear_spaces() == std::vector<std::string>{"linear", "doubled"});
    CHECK(raylex::display::equivalent(*manager->chromaticities("linear"), raylex::display::rec709_primaries()));
    const auto shown =
        manager->to_display(std::vector<float>{0.25f, 0.25f, 1.0f}, raylex::display::rec709_primaries(), "", "");
    REQUIRE(shown.ok());
    CHECK(*shown == std::vector<unsigned char>{128, 128, 255});  // square roots: 127.5 rounds up
}

TEST_CASE("matrices from primaries are those of the standards", "[display][color]") {
    using namespace raylex::display;
    // IEC 61966-2-1 gives four digits; three tables of the standard differ in the fifth.
    const Matrix3 xyz = rgb_to_xyz(rec709_primaries());
    CHECK(xyz[0][0] == Approx(0.4124).margin(5e-5));
    CHECK(xyz[1][1] == Approx(0.7152).margin(5e-5));
    CHECK(xyz[2][2] == Approx(0.9505).margin(1e-4));
    // S-2014-004, AP1 to XYZ: it gives ten digits, six are compared.
    CHECK(rgb_to_xyz(aces_ap1_primaries())[0][0] == Approx(0.6624541811).margin(1e-6));
    CHECK(rgb_to_xyz(aces_ap0_primaries())[1][2] == Approx(-0.0721325464).margin(1e-6));
    const Matrix3 there = rgb_to_rgb(rec709_primaries(), aces_ap1_primaries()),
                  back = rgb_to_rgb(aces_ap1_primaries(), rec709_primaries());
    const Matrix3 both = multiply(back, there);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            CHECK(both[i][j] == Approx(i == j ? 1.0 : 0.0).margin(1e-12));  // double rounding
    CHECK(rgb_to_rgb(rec709_primaries(), {{0.64, 0.33}, {0.3, 0.60004}, {0.15, 0.06}, {0.3127, 0.329}}) ==
          identity_matrix());
    CHECK(luminance_weights(rec709_primaries()) == std::array{0.2126, 0.7152, 0.0722});
    const auto weights = luminance_weights(aces_ap1_primaries());
    CHECK(weights[0] + weights[1] + weights[2] == Approx(1.0).margin(1e-12));
    CHECK(inverse(Matrix3{}) == Matrix3{});
}
