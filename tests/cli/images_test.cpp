// Pictures of any OpenEXR file, names of the colour config, error images, single-part files and crops, as a user
// requests them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include "../display/files.h"
#include "display/output/color/color_manager.h"
#include "display/output/color/color_names.h"
#include "display/output/reader/exr_reader.h"
#include "experiments/job/text/json.h"
#include "experiments/report/preview.h"
#include "support.h"
#include "support/paths.h"
#include "support/skip.h"

using namespace raylex::test;
using raylex::display::read_exr;
using raylex::experiments::LayerLook;
namespace display = raylex::display;

namespace {

constexpr int width = 6, height = 4;

std::vector<float> ramp(float first, float step) {
    std::vector<float> values;
    for (int i = 0; i < width * height; ++i) values.push_back(first + step * static_cast<float>(i));
    return values;
}

/// Returns the picture of a layer as preview makes it, without running the program.
raylex::experiments::Picture picture(const Folder& folder, const std::string& file, const std::string& layer,
                                     const std::string& view = {}) {
    auto image = read_exr(folder.path(file));
    REQUIRE(image);
    auto color = display::ColorManager::open();
    REQUIRE(color);
    auto found = image->require_layer(layer);
    REQUIRE(found);
    raylex::experiments::PictureOptions options;
    options.view = view;
    auto made = raylex::experiments::picture_of(*image, **found, *color, options);
    REQUIRE(made);
    return *made;
}

std::vector<unsigned char> pixel(const raylex::experiments::Picture& of, std::size_t i) {
    return {of.rgb[3 * i], of.rgb[3 * i + 1], of.rgb[3 * i + 2]};
}

}  // namespace

TEST_CASE("a preview shows any OpenEXR file: half, single part, luminance alone, depths, vectors, foreign names") {
    const Folder folder;
    const std::vector<float> values = ramp(0, 0.05f), none(width * height, 0.0f);
    write_foreign(folder.path("half.exr"),
                  {{"R", Imf::HALF, values},
                   {"G", Imf::HALF, values},
                   {"B", Imf::HALF, none},
                   {"Z", Imf::FLOAT, ramp(1, 1)},
                   {"N.X", Imf::HALF, none},
                   {"N.Y", Imf::HALF, none},
                   {"N.Z", Imf::HALF, std::vector<float>(width * height, 1.0f)},
                   {"id", Imf::UINT, ramp(0, 1)},
                   {"flow.U", Imf::FLOAT, values},
                   {"flow.V", Imf::FLOAT, none}},
                  width, height);
    const Outcome outcome = run_raylex(folder, "preview half.exr --view Raw");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out == "half.png: 6x4, beauty through Raw of sRGB - Display\n");
    CHECK(folder.read("half.png").substr(1, 3) == "PNG");
    CHECK(pixel(picture(folder, "half.exr", "", "Raw"), 4) == std::vector<unsigned char>{51, 51, 0});
    CHECK(run_raylex(folder, "preview half.exr --layer Z -o z.png").out ==
          "z.png: 6x4, Z, near is bright, nothing hit is black\n");
    CHECK(pixel(picture(folder, "half.exr", "Z"), 0)[0] == 255);
    CHECK(pixel(picture(folder, "half.exr", "N"), 0) == std::vector<unsigned char>{128, 128, 255});
    CHECK(pixel(picture(folder, "half.exr", "id"), 0) == std::vector<unsigned char>{0, 0, 0});
    CHECK(pixel(picture(folder, "half.exr", "id"), 1) != pixel(picture(folder, "half.exr", "id"), 2));
    CHECK(pixel(picture(folder, "half.exr", "flow"), 23) == std::vector<unsigned char>{255, 128, 0});  // V is constant

    // Luminance alone counts as light; with chroma, as OpenEXR defines it, it is a colour: Y = 0.2126 R + 0.7152 G +
    // 0.0722 B.
    write_foreign(folder.path("grey.exr"), {{"Y", Imf::HALF, values}, {"A", Imf::HALF, values}}, width, height);
    CHECK(pixel(picture(folder, "grey.exr", "", "Raw"), 8) == std::vector<unsigned char>{102, 102, 102});
    write_foreign(folder.path("grey2.exr"), {{"Y", Imf::FLOAT, values}}, width, height);
    CHECK(pixel(picture(folder, "grey2.exr", "", "Raw"), 8) == std::vector<unsigned char>{102, 102, 102});
    const double y = 0.2126 * 0.8 + 0.7152 * 0.4 + 0.0722 * 0.2;
    const std::vector<float> luma(width * height, static_cast<float>(y)),
        ry(width * height, static_cast<float>(0.8 / y - 1)), by(width * height, static_cast<float>(0.2 / y - 1));
    write_foreign(folder.path("chroma.exr"), {{"Y", Imf::FLOAT, luma}, {"RY", Imf::FLOAT, ry}, {"BY", Imf::FLOAT, by}},
                  width, height);
    CHECK(pixel(picture(folder, "chroma.exr", "", "Raw"), 3) == std::vector<unsigned char>{204, 102, 51});

    // Blender's names, its depth for empty pixels, and a file without a nameless layer.
    std::vector<float> depth = ramp(1, 1);
    depth[0] = 1e10f;
    write_foreign(folder.path("blender.exr"),
                  {{"ViewLayer.Combined.R", Imf::HALF, values},
                   {"ViewLayer.Combined.G", Imf::HALF, values},
                   {"ViewLayer.Combined.B", Imf::HALF, values},
                   {"ViewLayer.Depth.V", Imf::FLOAT, depth}},
                  width, height);
    CHECK(run_raylex(folder, "preview blender.exr -o b.png").out.find("ViewLayer.Combined through") !=
          std::string::npos);
    CHECK(run_raylex(folder, "compare blender.exr blender.exr").out == "0\n");
    CHECK(pixel(picture(folder, "blender.exr", "ViewLayer.Depth"), 0)[0] == 0);
    CHECK(pixel(picture(folder, "blender.exr", "ViewLayer.Depth"), 1)[0] == 255);
    write_foreign_parts(folder.path("parts.exr"),
                        {{"depth", {{"Z", Imf::FLOAT, depth}}}, {"mask", {{"mask", Imf::HALF, values}}}}, width,
                        height);
    CHECK(run_raylex(folder, "preview parts.exr -o p.png").code == 0);
    CHECK(run_raylex(folder, "preview parts.exr --layer mask -o m.png").out.find("from the least to the largest") !=
          std::string::npos);

    // The page has the same pictures for any planes.
    const Outcome page = run_raylex(folder, "report half.exr grey.exr chroma.exr blender.exr parts.exr -o page.html");
    CAPTURE(page.err);
    CHECK(page.code == 0);
    folder.write("page.html", "");

    // Exposures and sizes.
    CHECK(run_raylex(folder, "preview half.exr --exposure 2 --size 3 -o bright.png").out.find("3x2, beauty through") !=
          std::string::npos);
    CHECK(run_raylex(folder, "preview half.exr --exposure 60 -o white.png").code == 0);
}

TEST_CASE("Blender reads every layer of a file with ids and single values, each with its values", "[.full]") {
    if (std::system("blender --version >/dev/null 2>&1") != 0) RAYLEX_SKIP("blender is not installed");
    const SceneFolder folder;
    const std::string script = source_dir() + "/tests/experiments/data/blender_reads.py";
    const Outcome read = run_shell(folder,
                                   "\"$RAYLEX\" render room.pbrt -o a.exr --aov id --aov VLen --aov zback --aov u "
                                   "--aov Nn --aov albedo --cryptomatte "
                                   "object --statistics beauty=mse --layer zfar=z:zmax --layer depth=z:zmin --lpe "
                                   "'direct=C<RD>L' >&2 && blender -b --factory-startup --python '" +
                                       script + "' -- a.exr");
    CAPTURE(read.out, read.err);
    REQUIRE(read.code == 0);
    auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image);
    std::size_t layers = 0;
    for (const auto& line : all_matches(read.out, "layer (\\S+) (\\S+)\n")) {
        CAPTURE(line[0]);
        if (line[1] == "Alpha") continue;
        const display::ImageLayer* layer = image->layer(line[1] == "Combined" ? "" : line[1]);
        REQUIRE(layer != nullptr);
        float largest = 0;
        for (std::size_t k = 0; k < 3; ++k)
            for (const float value : layer->planes[std::min(k, layer->planes.size() - 1)].values)
                largest = std::max(largest, value);
        CHECK(std::stof(line[2]) == Approx(largest).epsilon(1e-6));  // float in, float out
        ++layers;
    }
    CHECK(layers + 4 == image->layers.size());  // all but id, VLen, zback and zfar, which Blender does not support
}

TEST_CASE("for an unknown name, preview suggests the closest match", "[law7]") {
    const Folder folder;
    const std::vector<float> values = ramp(0, 0.05f);
    write_foreign(folder.path("a.exr"),
                  {{"R", Imf::FLOAT, values},
                   {"G", Imf::FLOAT, values},
                   {"B", Imf::FLOAT, values},
                   {"caustics.R", Imf::FLOAT, values},
                   {"caustics.G", Imf::FLOAT, values},
                   {"caustics.B", Imf::FLOAT, values}},
                  width, height);
    check_refused(folder, "preview a.exr --layer caustic", {"no layer 'caustic'", "did you mean 'caustics'?"});
    check_refused(folder, "preview a.exr --display sRGB", {"no display 'sRGB'", "did you mean 'sRGB - Display'?"});
    check_refused(folder, "preview a.exr --view Rwa",
                  {"no view 'Rwa' of display 'sRGB - Display'", "did you mean 'Raw'?"});
    check_refused(folder, "preview a.exr --view 'ACES 1.1 - HDR Video (1000 nits & P3 lim)'",
                  {"display 'ST2084-P3-D65 - Display' has such a view"});
    check_refused(folder, "preview a.exr -o a.jpg", {"'a.jpg' does not end in .png"});
    check_refused(folder, "preview a.exr -o ''", {"the name is empty"});
    check_refused(folder, "preview a.exr --ocio absent.ocio", {"absent.ocio"});
    check_refused(folder, "preview absent.exr", {"absent.exr"});
    check_refused(folder, "preview a.exr --exposure 1000", {"--exposure"});
    folder.write("room.pbrt", small_scene());
    check_refused(folder, "render room.pbrt --preview r.png --display sRGB", {"did you mean 'sRGB - Display'?"});
    check_refused(folder, "render room.pbrt --rendering-space ACEScgg", {"did you mean 'ACEScg'?"});
}

TEST_CASE("ocio lists the values of the options for the config in use") {
    const Folder folder;
    const Outcome shipped = run_raylex(folder, "ocio");
    CHECK(shipped.code == 0);
    for (const char* line : {"  sRGB - Display  (default)\n", "    ACES 1.0 - SDR Video  (default)\n", "    Raw\n",
                             "  ACEScg  (scene-linear)\n", "  Raw  (data)\n", "looks"})
        CHECK(shipped.out.find(line) != std::string::npos);
    folder.write("own.ocio",
                 "ocio_profile_version: 2\nroles: {default: lin, scene_linear: lin}\nlooks:\n  - !<Look> {name: warm, "
                 "process_space: lin}\n"
                 "displays:\n  tv:\n    - !<View> {name: plain, colorspace: lin}\ncolorspaces:\n  - !<ColorSpace> "
                 "{name: lin, encoding: scene-linear}\n");
    for (const std::string& line :
         {std::string("\"$RAYLEX\" ocio --ocio own.ocio"), std::string("OCIO=own.ocio \"$RAYLEX\" ocio")}) {
        const Outcome own = run_shell(folder, line);
        CAPTURE(own.err);
        CHECK(own.code == 0);
        CHECK(own.out.find("  tv  (default)\n    plain  (default)\n") != std::string::npos);
        CHECK(own.out.find("looks:\n  warm\n") != std::string::npos);
        CHECK(own.out.find("sRGB") == std::string::npos);
    }
    CHECK(run_raylex(folder, "ocio --ocio absent.ocio").code == 2);
}

TEST_CASE("displays and views in the documentation exist in raylex's config") {
    auto color = display::ColorManager::open();
    REQUIRE(color);
    std::size_t found = 0;
    const auto check = [&](const std::string& file) {
        const std::string text = read_bytes(file);
        // --view NAME and --view 'NAME' in commands, view = "NAME" in jobs. Help texts contain the literal NAME.
        const std::string option =
            "--(display|view)[ =]+('([^']*)'|\"([^\"]*)\"|([^\\s'\"`\\]]+))|\\b(display|view) = \"([^\"]*)\"";
        for (const std::vector<std::string>& match : all_matches(text, option)) {
            const std::string kind = match[1] + match[6], name = match[3] + match[4] + match[5] + match[7];
            if (name == "NAME" || name.starts_with("-") || name.find_first_of(",;|)") != std::string::npos) continue;
            CAPTURE(file, kind, name);
            if (kind == "display") {
                CHECK(display::check_view(*color, name, "").ok());
            } else {
                const std::vector<std::string> displays = color->displays();
                CHECK(std::any_of(displays.begin(), displays.end(), [&](const std::string& each) {
                    return display::check_view(*color, each, name).ok();
                }));
            }
            ++found;
        }
    };
    namespace fs = std::filesystem;
    check(source_dir() + "/README.md");
    check(source_dir() + "/experiments/README.md");
    for (const fs::directory_entry& each : fs::recursive_directory_iterator(source_dir() + "/experiments/docs"))
        if (each.path().extension() == ".md") check(each.path().string());
    CHECK(found >= 3);  // experiments/docs/images.md contains some
}

TEST_CASE("compare prints all metrics, as JSON too, and writes error images") {
    const Folder folder;
    std::vector<float> dark = ramp(0.1f, 0), light = ramp(0.1f, 0);
    light[9] = 0.6f;
    const auto write = [&](const std::string& name, const std::vector<float>& values) {
        write_foreign(folder.path(name),
                      {{"R", Imf::FLOAT, values}, {"G", Imf::FLOAT, values}, {"B", Imf::FLOAT, values}}, width, height);
    };
    write("a.exr", light);
    write("b.exr", dark);
    const Outcome all = run_raylex(folder, "compare a.exr b.exr --metric all");
    CAPTURE(all.out, all.err);
    REQUIRE(all.code == 0);
    for (const char* name : {"relmse ", "mse ", "mean-ratio ", "ssim ", "flip ", "hdr-flip "})
        CHECK(all.out.find(name) != std::string::npos);
    const auto json =
        raylex::experiments::parse_json(run_raylex(folder, "compare a.exr b.exr --metric all --json").out);
    CHECK(json["metrics"].size() == 12);
    CHECK(json["metrics"]["mae"].get<double>() == Approx(0.5 / 24).epsilon(1e-6));
    CHECK(json["metrics"]["flip"].get<double>() > 0.01);
    CHECK(json["metrics"]["ssim"].get<double>() < 0.99);
    CHECK(json["reference"] == "b.exr");
    CHECK(std::stod(run_raylex(folder, "compare a.exr b.exr --metric hdr-flip").out) ==
          Approx(json["metrics"]["hdr-flip"].get<double>()));
    const auto one =
        raylex::experiments::parse_json(run_raylex(folder, "compare a.exr b.exr --channel R --json --metric all").out);
    CHECK(one["metrics"]["flip"].is_null());
    CHECK(one["without_value"]["flip"].get<std::string>().find("--channel") != std::string::npos);

    const Outcome exr = run_raylex(folder, "compare a.exr b.exr --metric mae -o e.exr");
    REQUIRE(exr.code == 0);
    CHECK(exr.out == run_raylex(folder, "compare a.exr b.exr --metric mae").out);
    CHECK(exr.err.find("largest 0.5 at pixel (3, 1)") != std::string::npos);
    auto errors = read_exr(folder.path("e.exr"));
    REQUIRE(errors);
    CHECK(errors->attributes["raylex/metric"] == "mae");
    const display::ImageLayer* layer = errors->layer("error");
    REQUIRE(layer != nullptr);
    for (std::size_t i = 0; i < 24; ++i) CHECK(layer->planes.front().values[i] == (i == 9 ? Approx(0.5) : Approx(0)));
    const Outcome png = run_raylex(folder, "compare a.exr b.exr --metric flip -o e.png");
    REQUIRE(png.code == 0);
    CHECK(png.err.find("pale yellow 1 and above") != std::string::npos);
    CHECK(folder.read("e.png").substr(1, 3) == "PNG");

    // A crop is compared as it is, with a note.
    const SceneFolder scene;
    REQUIRE(run_raylex(scene, "render room.pbrt --spp 1 -o whole.exr").code == 0);
    REQUIRE(run_raylex(scene, "render room.pbrt --spp 1 --crop 1,2,4,5 -o crop.exr").code == 0);
    CHECK(
        contains(run_raylex(scene, "compare crop.exr whole.exr").err, "crop.exr: the file has pixels only in 1,2,4,5"));
    CHECK_FALSE(contains(run_raylex(scene, "compare whole.exr whole.exr").err, "alone"));

    check_refused(folder, "compare a.exr b.exr --metric fllip", {"unknown metric 'fllip'", "did you mean 'flip'?"});
    check_refused(folder, "compare a.exr b.exr --metric all -o x.png", {"shows one metric"});
    check_refused(folder, "compare a.exr b.exr --metric mean-ratio -o x.png", {"not defined for single pixels"});
    check_refused(folder, "compare a.exr b.exr -o x.jpg", {"end in .exr or .png"});
    check_refused(folder, "compare a.exr b.exr -o ''", {"the name is empty"});
    check_refused(folder, "compare a.exr b.exr -o b.exr", {"'b.exr'"});
    check_refused(folder, "compare a.exr b.exr -o absent/x.png", {"absent/x.png"});
}

TEST_CASE("render --help shows options in groups, and --color colours words") {
    const Folder folder;
    const std::string short_help = run_raylex(folder, "render --help").out;
    CHECK(short_help.ends_with("'raylex render --help-all' lists all options.\n"));
    CHECK(short_help.find("--spp") != std::string::npos);
    CHECK(short_help.find("--deep-tidy") == std::string::npos);
    const std::string help = run_raylex(folder, "render --help-all").out;
    std::size_t last = 0;
    for (const char* group :
         {"\nFiles and viewers:", "\nSampling:", "\nImage:", "\nLong renders:", "\nMachine:", "\nLight transport:",
          "\nLayers of light:", "\nOther layers:", "\nColour and previews:", "\nFilters:"}) {
        CAPTURE(group);
        const std::size_t at = help.find(group);
        REQUIRE(at != std::string::npos);
        CHECK(at > last);
        last = at;
    }
    CHECK(help.find("--spp") > help.find("\nSampling:"));
    CHECK(help.find("--spp") < help.find("\nImage:"));
    const auto error = [&](const std::string& line) { return run_shell(folder, line).err; };
    const std::string red = "raylex: \x1b[1;31merror:\x1b[0m ";
    CHECK(error("\"$RAYLEX\" verify absent.exr").starts_with("raylex: error: "));
    CHECK(error("\"$RAYLEX\" verify absent.exr --color always").starts_with(red));
    CHECK(error("\"$RAYLEX\" --color always verify absent.exr").starts_with(red));
    CHECK(
        // --color always overrides NO_COLOR
        error("NO_COLOR=1 \"$RAYLEX\" verify absent.exr --color always").starts_with(red));
    CHECK(error("\"$RAYLEX\" verify --color sometimes absent.exr").find("--color") != std::string::npos);
    // A terminal, made by script(1): coloured, except with NO_COLOR, a dumb terminal, or --color never.
    const auto seen = [&](const std::string& variables, const std::string& options) {
        return run_shell(folder,
                         "env " + variables + " script -qec \"'$RAYLEX' verify absent.exr " + options + "\" /dev/null")
            .out;
    };
    CHECK(seen("TERM=xterm", "").find(red) != std::string::npos);
    CHECK(seen("TERM=xterm NO_COLOR=", "").find(red) != std::string::npos);
    CHECK(seen("TERM=xterm NO_COLOR=1", "").find("\x1b") == std::string::npos);
    CHECK(seen("TERM=dumb", "").find("\x1b") == std::string::npos);
    CHECK(seen("TERM=xterm", "--color never").find("\x1b") == std::string::npos);
}
