// verify on images of other renderers: one rendered by Blender (data/cycles.exr, by data/cycles_image.py), the same
// image in other storages, and synthetic files with the layer names of RenderMan, Arnold and V-Ray.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <random>

#include "experiments/verify/presets.h"
#include "support.h"
#include "tests/display/files.h"
#include "tests/support/paths.h"
#include "tests/support/skip.h"

using namespace raylex::test;
namespace display = raylex::display;

namespace {

std::string cycles_image() {
    return source_dir() + "/tests/experiments/data/cycles.exr";
}

display::ExrImage read(const std::string& path) {
    auto image = display::read_exr(path);
    if (!image) FAIL(image.error().to_string());
    return *image;
}

/// Writes an image's layers as one part, in another storage.
void write(const std::string& path, const display::ExrImage& image, Imf::PixelType type = Imf::FLOAT,
           Imf::Compression compression = Imf::ZIP_COMPRESSION) {
    std::vector<ForeignChannel> channels;
    for (const display::ImageLayer& layer : image.layers)
        for (const display::ImagePlane& plane : layer.planes)
            channels.push_back({(layer.name.empty() ? "" : layer.name + ".") + plane.name, type, plane.values});
    Imf::Header header(image.width, image.height);
    header.compression() = compression;
    const ForeignPixels pixels(channels, box(image.width, image.height), header);
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(pixels.buffer());
    file.writePixels(image.height);
}

display::ImageLayer& layer_of(display::ExrImage& image, const std::string& name) {
    for (display::ImageLayer& layer : image.layers)
        if (layer.name == name) return layer;
    FAIL("no layer " << name);
    throw 0;
}

void scale(display::ExrImage& image, const std::string& name, float factor) {
    for (display::ImagePlane& plane : layer_of(image, name).planes)
        for (float& value : plane.values) value *= factor;
}

/// Makes random layers of these names and, under `whole`, the layer that `sum` computes from each pixel's values.
template <class Sum>
display::ExrImage synthetic(const std::vector<std::string>& names, const std::string& whole, Sum&& sum) {
    std::mt19937 random(11);
    std::lognormal_distribution<float> light(0.0f, 2.0f);
    constexpr int width = 13, height = 9;
    std::vector<std::vector<std::array<float, 3>>> values(names.size() + 1);
    for (int i = 0; i < width * height; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<float> here;
            for (std::size_t n = 0; n < names.size(); ++n) {
                if (c == 0) values[n].emplace_back();
                values[n].back()[c] = light(random);
                here.push_back(values[n].back()[c]);
            }
            if (c == 0) values.back().emplace_back();
            values.back().back()[c] = sum(here);
        }
    std::vector<display::ImageLayer> layers{color_layer(whole, values.back())};
    for (std::size_t n = 0; n < names.size(); ++n) layers.push_back(color_layer(names[n], values[n]));
    return image_of(width, height, std::move(layers));
}

float plain_sum(const std::vector<float>& values) {
    float sum = 0;
    for (const float value : values) sum += value;
    return sum;
}

}  // namespace

TEST_CASE("an image of Cycles gets the right result by preset, in one command", "[verify]") {
    const Folder folder;
    const Outcome outcome = run_raylex(folder, "verify '" + cycles_image() + "' --preset cycles");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "Cycles (Blender) passes of ViewLayer: 11 layers against ViewLayer.Combined: holds"));
    CHECK(contains(outcome.out,
                   "Cycles (Blender) light groups of ViewLayer: 3 layers against ViewLayer.Combined: holds"));
    CHECK(contains(outcome.out,
                   "(DiffDir + DiffInd) * DiffCol, (GlossDir + GlossInd) * GlossCol, (TransDir + TransInd) * "
                   "TransCol, Emit, Env"));
    CHECK(contains(outcome.out, "relative 3.81e-06, for the float sum of 64 samples, 2^-24 each"));
    // Without options, the preset is suggested.
    const Outcome nothing = run_raylex(folder, "verify '" + cycles_image() + "'");
    CHECK(nothing.code == 2);
    CHECK(contains(nothing.err, " --preset cycles"));
}

TEST_CASE("sums are written as arithmetic, with short names, and judged by --tolerance", "[verify]") {
    const Folder folder;
    folder.write("a.exr", read_bytes(cycles_image()));
    const std::string sum =
        " --sum '(DiffDir+DiffInd)*DiffCol, (GlossDir+GlossInd)*GlossCol, (TransDir+TransInd)*TransCol, "
        "Emit, Env'";
    // Without --of: Combined is the application's name of the beauty, and the result names it.
    Outcome outcome = run_raylex(folder, "verify a.exr --tolerance 0,4e-6" + sum);
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "11 layers against ViewLayer.Combined: holds"));
    CHECK(run_raylex(folder, "verify a.exr --of Combined --sum 'Combined_*' --tolerance 1e-4,0").code == 0);
    outcome =
        run_raylex(folder, "verify a.exr --of Combined --tolerance 0,4e-6 --sum '(DiffDir+DiffInd)*DiffCol, Emit'");
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out, "DOES NOT HOLD"));
    CHECK(contains(outcome.out, "light is missing from the layers"));
    CHECK(folder.has("a.sum.residual.png"));
    outcome = run_raylex(folder, "verify a.exr --of Combined --sum '(DiffDir+DiffInd)*DifCol'");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "--sum: column 19: the image has no layer 'DifCol'"));
    CHECK(contains(outcome.err, "did you mean 'DiffCol'?"));
    for (const char* wrong : {"1e-6", "1e-6,", ",1e-6", "-1,0", "0,nan", "0,0,0", "a,b", "''"}) {
        CAPTURE(wrong);
        outcome = run_raylex(folder, "verify a.exr --preset cycles --tolerance " + std::string(wrong));
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, "--tolerance: column "));
    }
    CHECK(run_raylex(folder, "verify a.exr --preset cycles --sum Emit").code == 2);
    CHECK(run_raylex(folder, "verify a.exr --of Combined --sum ''").code == 2);
    outcome = run_raylex(folder, "verify a.exr --preset cycle");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "did you mean 'cycles'?"));
    outcome = run_raylex(folder, "verify a.exr --preset arnold");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "no layers with names of Arnold"));
}

TEST_CASE("an image of Cycles holds in any storage, and fails with a wrong pass", "[verify]") {
    const Folder folder;
    const display::ExrImage image = read(cycles_image());
    display::ExrImage wrong = image;
    scale(wrong, "ViewLayer.GlossInd", 1.5f);
    const raylex::experiments::Preset& preset = **raylex::experiments::find_preset("cycles");
    const auto answers = [&](const std::string& path) {
        const display::ExrImage stored = read(path);
        auto splits = raylex::experiments::find_splits(preset, stored, "");
        REQUIRE(splits);
        std::vector<display::SplitAnswer> all;
        for (const auto& split : *splits)
            all.push_back(display::check_split(stored, split.of, {split.sum}, split.allowance)->answer);
        return all;
    };
    using display::SplitAnswer;
    struct Case {
        Imf::PixelType type;
        Imf::Compression compression;
        SplitAnswer answer;
    };
    for (const Case& each : {Case{Imf::HALF, Imf::ZIP_COMPRESSION, SplitAnswer::holds_to_rounding},
                             {Imf::HALF, Imf::ZIPS_COMPRESSION, SplitAnswer::holds_to_rounding},
                             {Imf::HALF, Imf::PIZ_COMPRESSION, SplitAnswer::holds_to_rounding},
                             {Imf::FLOAT, Imf::PXR24_COMPRESSION, SplitAnswer::holds_to_rounding},
                             {Imf::HALF, Imf::DWAA_COMPRESSION, SplitAnswer::holds_as_allowed},
                             {Imf::HALF, Imf::DWAB_COMPRESSION, SplitAnswer::holds_as_allowed},
                             {Imf::FLOAT, Imf::DWAA_COMPRESSION, SplitAnswer::holds_as_allowed}}) {
        CAPTURE(each.type, each.compression);
        write(folder.path("a.exr"), image, each.type, each.compression);
        CHECK(answers(folder.path("a.exr")) == std::vector<SplitAnswer>{each.answer, each.answer});
        write(folder.path("b.exr"), wrong, each.type, each.compression);
        CHECK(answers(folder.path("b.exr")) == std::vector<SplitAnswer>{SplitAnswer::does_not_hold, each.answer});
    }
}

TEST_CASE("a rebuild that lacks light says which, as numbers, as an image and on the page", "[verify][report]") {
    const Folder folder;
    folder.write("a.exr", read_bytes(cycles_image()));
    const std::string lobes =
        "(DiffDir+DiffInd)*DiffCol, (GlossDir+GlossInd)*GlossCol, (TransDir+TransInd)*TransCol, Emit";
    Outcome outcome = run_raylex(folder, "verify a.exr --tolerance 0,4e-6 --sum '" + lobes + "'");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 1);
    CHECK(count_matches(outcome.out,
                        "unassigned light \\(ViewLayer.Combined minus sum\\): [0-9.]+ % of "
                        "'ViewLayer.Combined' in \\d+ pixels, at most .*; it equals the layer "
                        "'ViewLayer.Env', which the sum lacks\n") == 1);
    CHECK(contains(outcome.out, "unassigned where 'ViewLayer.DiffCol' is 0: "));
    CHECK(contains(outcome.out, "a.sum.unassigned.exr (layers unassigned, counted_twice)"));
    const display::ExrImage light = read(folder.path("a.sum.unassigned.exr"));
    const std::vector<float> lacking = plane(light, "unassigned", "G"),
                             sky = plane(read(cycles_image()), "ViewLayer.Env", "G");
    for (std::size_t i = 0; i < sky.size(); ++i) CHECK(lacking[i] == Approx(sky[i]).margin(1e-4));
    outcome = run_raylex(folder, "verify a.exr --tolerance 0,4e-6 --sum '" + lobes + "+Env, DiffDir*DiffCol'");
    CHECK(contains(outcome.out, "light counted twice (sum minus ViewLayer.Combined): "));
    outcome = run_raylex(folder, "verify a.exr --tolerance 0,4e-6 --sum '" + lobes + "+Env+Env'");
    CHECK(contains(outcome.out, "it equals the layer 'ViewLayer.Env', which the sum has once too often"));

    // The page finds the passes by their names.
    REQUIRE(run_raylex(folder, "report a.exr -o page.html").code == 0);
    CHECK(contains(folder.read("page.html"), "Cycles (Blender) passes of ViewLayer <span class=\"holds\">"));
    CHECK_FALSE(contains(folder.read("page.html"), "data-name=\"unassigned"));
    display::ExrImage image = read(cycles_image());
    scale(image, "ViewLayer.Env", 0.5F);
    scale(image, "ViewLayer.Emit", 3);
    write(folder.path("b.exr"), image);
    REQUIRE(run_raylex(folder, "report b.exr -o page.html").code == 0);
    const std::string page = folder.read("page.html");
    for (const char* text :
         {"passes of ViewLayer <span class=\"fails\">does not hold",
          "data-name=\"unassigned (Cycles (Blender) passes of ViewLayer)\"",
          "data-name=\"counted twice (Cycles (Blender) passes of ViewLayer)\"",
          "light groups of ViewLayer <span class=\"holds\">", "unassigned light (ViewLayer.Combined minus sum): "}) {
        CAPTURE(text);
        CHECK(contains(page, text));
    }
}

TEST_CASE("presets find view layers, files per layer, a noisy image and groups that lack light", "[verify]") {
    const Folder folder;
    display::ExrImage image = read(cycles_image());
    const display::ExrImage original = image;
    for (const display::ImageLayer& layer : original.layers)
        if (layer.name != "ViewLayer.Combined_sky") {
            image.layers.push_back(layer);
            image.layers.back().name.replace(0, std::string("ViewLayer").size(), "Back Layer");
        }
    write(folder.path("two.exr"), image);
    Outcome outcome = run_raylex(folder, "verify two.exr --preset cycles");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out, "passes of Back Layer: 11 layers against Back Layer.Combined: holds"));
    CHECK(contains(outcome.out, "light groups of Back Layer: 2 layers against Back Layer.Combined: DOES NOT HOLD"));
    CHECK(contains(outcome.out, "every lamp, emitter and the world"));
    CHECK(contains(outcome.out, "relative 4e-05, for Cycles' float sum of samples, measured at 4096 samples"));
    CHECK(contains(outcome.out, "light groups of ViewLayer: 3 layers against ViewLayer.Combined: holds"));
    CHECK(folder.has("two.light-groups-of-Back-Layer.residual.png"));

    // The denoised Combined is not checked if the image before denoising is stored.
    image = original;
    layer_of(image, "ViewLayer.Combined").name = "ViewLayer.Noisy Image";
    image.layers.push_back(layer_of(image, "ViewLayer.Noisy Image"));
    image.layers.back().name = "ViewLayer.Combined";
    scale(image, "ViewLayer.Combined", 1.1f);
    write(folder.path("denoised.exr"), image);
    outcome = run_raylex(folder, "verify denoised.exr --preset cycles");
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "against ViewLayer.Noisy Image: holds"));
    CHECK(run_raylex(folder, "verify denoised.exr --preset cycles --of Combined").code == 1);

    // A transparent film: the background is in its pass and in its light group, but not in the image.
    image = original;
    const auto value = [&original](const char* pass, std::size_t c, std::size_t i) {
        return static_cast<double>(original.layer(std::string("ViewLayer.") + pass)->planes[c].values[i]);
    };
    display::ImageLayer& whole = layer_of(image, "ViewLayer.Combined");
    for (std::size_t i = 0; i < whole.planes[0].values.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c)
            whole.planes[c].values[i] = static_cast<float>(
                (value("DiffDir", c, i) + value("DiffInd", c, i)) * value("DiffCol", c, i) +
                (value("GlossDir", c, i) + value("GlossInd", c, i)) * value("GlossCol", c, i) +
                (value("TransDir", c, i) + value("TransInd", c, i)) * value("TransCol", c, i) + value("Emit", c, i));
        if (value("Env", 2, i) > 0) whole.planes[3].values[i] = 0.5f;
    }
    write(folder.path("film.exr"), image);
    outcome = run_raylex(folder, "verify film.exr --preset cycles");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "the film is transparent"));
    CHECK(contains(outcome.out, "Combined_sky, -Env"));

    // One file per layer.
    std::string files;
    for (const display::ImageLayer& layer : original.layers) {
        display::ExrImage single = image_of(original.width, original.height, {layer});
        single.layers.front().name.clear();
        const std::string name = "shot_" + layer.name.substr(layer.name.find('.') + 1) + ".0001.exr";
        write(folder.path(name), single);
        files += " " + name;
    }
    outcome = run_raylex(folder, "verify" + files + " --preset cycles");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "passes: 11 layers against shot_Combined: holds"));

    // A missing pass is named; its factor alone is not light.
    image = original;
    image.layers.erase(std::remove_if(image.layers.begin(), image.layers.end(),
                                      [](const auto& layer) { return layer.name == "ViewLayer.DiffInd"; }),
                       image.layers.end());
    write(folder.path("less.exr"), image);
    outcome = run_raylex(folder, "verify less.exr --preset cycles");
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out, "missing from the file and the sum: DiffInd, SubsurfaceDir"));
}

TEST_CASE("presets know the names of RenderMan, Arnold and V-Ray, on synthetic files", "[verify]") {
    const Folder folder;
    const auto code = [&folder](const display::ExrImage& image, const std::string& preset) {
        write(folder.path("x.exr"), image);
        const Outcome outcome = run_raylex(folder, "verify x.exr --preset " + preset);
        UNSCOPED_INFO(outcome.out << outcome.err);
        return outcome.code;
    };
    struct Case {
        const char *preset, *whole;
        std::vector<std::string> names;
    };
    for (const Case& each :
         {Case{"renderman",
               "",
               {"directDiffuse", "indirectDiffuse", "subsurface", "directSpecular", "indirectSpecular", "transmissive",
                "emissive"}},
          {"renderman",
           "Ci",
           {"directDiffuseLobe", "indirectDiffuseLobe", "directSpecularGlassLobe", "transmissiveGlassLobe",
            "subsurfaceLobe", "emissive"}},
          {"arnold",
           "",
           {"diffuse", "specular", "coat", "sheen", "transmission", "sss", "volume", "emission", "background"}},
          {"arnold",
           "RGBA",
           {"diffuse_direct", "diffuse_indirect", "specular", "sss_direct", "sss_indirect", "background"}},
          {"arnold", "RGBA", {"direct", "indirect", "emission", "background"}},
          {"arnold", "", {"RGBA_key", "RGBA_rim", "RGBA_default"}},
          {"vray",
           "",
           {"VRayLighting", "VRayGlobalIllumination", "VRayReflection", "VRayRefraction", "VRaySpecular", "VRaySSS2",
            "VRaySelfIllumination", "VRayCaustics", "VRayAtmosphere", "VRayBackground"}},
          {"vray", "RGB_color", {"lighting", "GI", "reflect", "refract", "specular", "SSS", "selfIllum"}},
          {"vray",
           "rgba",
           {"atmospheric_effects", "background", "caustics", "gi", "lighting", "reflection", "specular"}}}) {
        CAPTURE(each.preset, each.whole, each.names);
        // Arnold's RGBA in a file without a nameless image, V-Ray's in a file with one, ...
        display::ExrImage image = synthetic(each.names, each.whole, plain_sum);
        image.layers.push_back(color_layer("albedo", std::vector<std::array<float, 3>>(13 * 9, {9, 9, 9})));
        CHECK(code(image, each.preset) == 0);
        image.layers.erase(image.layers.begin() + 1);
        CHECK(code(image, each.preset) == 1);
    }
    // V-Ray's raw elements: (diffuse filter) x (raw light + raw GI), reflections with their filter.
    const auto raw = [](const std::vector<float>& v) { return (v[0] + v[1]) * v[2] + v[3] * v[4] + v[5]; };
    display::ExrImage image = synthetic({"VRayRawLighting", "VRayRawGlobalIllumination", "VRayDiffuseFilter",
                                         "VRayRawReflection", "VRayReflectionFilter", "VRaySpecular"},
                                        "", raw);
    CHECK(code(image, "vray") == 0);
    write(folder.path("x.exr"), image);
    CHECK(contains(run_raylex(folder, "verify x.exr --preset vray").out,
                   "V-Ray raw elements: 6 layers against beauty: holds"));
}

TEST_CASE("verify reports what it cannot check: integers, missing channels, values that are not finite", "[verify]") {
    const Folder folder;
    const std::vector<float> one(12, 1.0f), half_of_it(12, 0.5f);
    std::vector<float> broken = half_of_it;
    broken[6] = std::numeric_limits<float>::quiet_NaN();
    std::vector<ForeignChannel> channels;
    for (const char* plane : {"R", "G", "B"}) {
        channels.push_back({plane, Imf::FLOAT, one});
        channels.push_back({"a." + std::string(plane), Imf::FLOAT, half_of_it});
        channels.push_back({"b." + std::string(plane), Imf::FLOAT, half_of_it});
        channels.push_back({"nan." + std::string(plane), Imf::FLOAT, broken});
        channels.push_back({"ids." + std::string(plane), Imf::UINT, one});
        if (*plane != 'B') channels.push_back({"two." + std::string(plane), Imf::FLOAT, half_of_it});
    }
    write_foreign(folder.path("x.exr"), channels, 4, 3);
    CHECK(run_raylex(folder, "verify x.exr --sum a,b").code == 0);
    Outcome outcome = run_raylex(folder, "verify x.exr --sum a,nan");
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out, "1 pixel holds values that are not finite, the first (2, 1) in nan"));
    outcome = run_raylex(folder, "verify x.exr --sum a,ids");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "layer 'ids' contains unsigned integers"));
    outcome = run_raylex(folder, "verify x.exr --sum a,two");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "layer 'two' has the channels R, G; expected R G B"));
    // Layers cropped to their lit part, each with its own data window.
    const Imath::Box2i display = box(4, 3);
    const auto planes = [](float value, std::size_t count) {
        std::vector<ForeignChannel> all;
        for (const char* plane : {"R", "G", "B"}) all.push_back({plane, Imf::HALF, std::vector<float>(count, value)});
        return all;
    };
    write_foreign(folder.path("left.exr"), planes(0.25f, 6), display, Imath::Box2i({0, 0}, {1, 2}));
    write_foreign(folder.path("right.exr"), planes(0.25f, 6), display, Imath::Box2i({2, 0}, {3, 2}));
    write_foreign(folder.path("all.exr"), planes(0.25f, 12), display, display);
    CHECK(run_raylex(folder, "verify all.exr left.exr right.exr --of all --sum left,right").code == 0);
    CHECK(run_raylex(folder, "verify all.exr left.exr right.exr --of all --sum left").code == 1);
}

TEST_CASE("Blender renders the test's image again, and verify gives the same result", "[.full][verify]") {
    if (std::system("blender --version >/dev/null 2>&1") != 0) RAYLEX_SKIP("blender is not installed");
    const Folder folder;
    const std::string script = source_dir() + "/tests/experiments/data/cycles_image.py";
    const Outcome rendered = run_shell(folder, "blender -b --factory-startup --python '" + script +
                                                   "' -- \"$PWD/anew.exr\" && exec \"$RAYLEX\" verify "
                                                   "anew.exr --preset cycles");
    CAPTURE(rendered.out, rendered.err);
    CHECK(rendered.code == 0);
    CHECK(contains(rendered.out, "passes of ViewLayer: 11 layers against ViewLayer.Combined: holds"));
}
