// Film and integrators of scene files: crops, exposure, white balance, pbrt's integrators as raylex's, and missing
// files.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "tests/transport/image_file.h"
#include "transport/color/camera_sensors.h"
#include "transport/color/spectral_data.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/integrators/integrator.h"
#include "transport/render/film.h"
#include "transport/render_support.h"
#include "transport/scene/film_sensor.h"
#include "transport/scene/typed_parameters.h"

using namespace raylex;
using namespace raylex::transport;

namespace film_tests {

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

const std::string world = R"(
Sampler "sobol" "integer pixelsamples" 4
Camera "perspective" "float fov" 40 SHUTTER
WorldBegin
LightSource "infinite" "rgb L" [0.5 0.25 0.125]
)";

RenderOutput rendered(const std::string& film, const std::string& shutter = "", const RenderSettings& settings = {}) {
    std::string text = film + world;
    text.replace(text.find("SHUTTER"), 7, shutter);
    return render_test::render_of(render_test::scene_of(text), settings);
}

TEST_CASE("crops of the film have the bits of the whole image", "[film][render]") {
    const std::string size = "Film \"rgb\" \"integer xresolution\" 10 \"integer yresolution\" 8 ";
    const auto region = [](const RenderOutput& output) {
        REQUIRE(output.view.crop.has_value());
        return std::array<int, 4>{output.view.crop->x0, output.view.crop->y0, output.view.crop->x1,
                                  output.view.crop->y1};
    };
    CHECK_FALSE(rendered(size).view.crop.has_value());
    CHECK_FALSE(rendered(size + "\"float cropwindow\" [0 1 0 1]").view.crop.has_value());
    // pbrt's order is x, x, y, y; a share of 0.3 of 10 pixels is 3, and 0.55 of 8 begins with pixel 5.
    CHECK(region(rendered(size + "\"float cropwindow\" [0.3 0.6 0.55 1]")) == std::array<int, 4>{3, 5, 6, 8});
    CHECK(region(rendered(size + "\"integer pixelbounds\" [2 7 1 4]")) == std::array<int, 4>{2, 1, 7, 4});
    RenderSettings doubled;
    doubled.film.resolution = {{20, 16}};
    CHECK(region(rendered(size + "\"integer pixelbounds\" [2 7 1 4]", "", doubled)) == std::array<int, 4>{4, 2, 14, 8});
    doubled.film.crop = {{1, 1, 3, 3}};  // the setting overrides the scene
    CHECK(region(rendered(size + "\"integer pixelbounds\" [2 7 1 4]", "", doubled)) == std::array<int, 4>{1, 1, 3, 3});
    const RenderOutput crop = rendered(size + "\"float cropwindow\" [0.3 0.6 0.5 1]"), whole = rendered(size);
    const std::vector<double> some = crop.frame_buffer.resolve(crop.beauty), all = whole.frame_buffer.resolve(0);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::size_t x = i / 3 % 10, y = i / 30;
        CHECK(some[i] == (x >= 3 && x < 6 && y >= 4 ? all[i] : 0));
    }
    CHECK(region(rendered(size + "\"integer pixelbounds\" [2 7 1 4] \"float cropwindow\" [0.3 0.6 0.55 1]")) ==
          std::array<int, 4>{3, 5, 6, 8});
    std::vector<Error> warnings;
    SceneEntity both;
    both.parameters.parameters = {typed::numbers("pixelbounds", ParameterType::integer, {2, 7, 1, 4}),
                                  typed::numbers("cropwindow", ParameterType::real, {0, 0.5, 0, 1})};
    both.parameters.parameters[0].location = {"test.pbrt", 3, 1};
    CHECK(read_film(both, std::nullopt, warnings).ok());
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].line == 3);
    CHECK(contains(warnings[0].message, "expected one of them, and 'pixelbounds' is ignored"));
    for (const auto& [name, values] : {std::pair{"cropwindow", std::vector<double>{0.5, 0.5, 0, 1}},
                                       {"cropwindow", {0, 1, 0}},
                                       {"pixelbounds", {2000, 3000, 0, 8}}}) {
        SceneEntity entity;
        entity.location = {"test.pbrt", 1, 1};
        entity.parameters.parameters = {typed::numbers(name, ParameterType::real, values)};
        entity.parameters.parameters[0].location = {"test.pbrt", 2, 1};
        const auto refused = read_film(entity, std::nullopt, warnings);
        REQUIRE_FALSE(refused.ok());
        CHECK(refused.error().line == 2);
    }
}

TEST_CASE("a film records exposure time times iso over 100", "[film][render]") {
    const auto pixel = [](const RenderOutput& output) {
        const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
        return std::array<double, 3>{image[0], image[1], image[2]};
    };
    const std::string size = "Film \"rgb\" \"integer xresolution\" 2 \"integer yresolution\" 2 ";
    const auto plain = pixel(rendered(size));
    // Powers of two, so exact.
    CHECK(plain == std::array<double, 3>{0.5, 0.25, 0.125});
    CHECK(pixel(rendered(size + "\"float iso\" 400")) == std::array<double, 3>{2, 1, 0.5});
    CHECK(pixel(rendered(size + "\"float iso\" 400", "\"float shutteropen\" 1 \"float shutterclose\" 1.125")) ==
          std::array<double, 3>{0.25, 0.125, 0.0625});
    CHECK(pixel(rendered(size + "\"float exposuretime\" 4")) == std::array<double, 3>{2, 1, 0.5});
    // A moment in time adds a warning.
    CHECK(pixel(rendered(size, "\"float shutteropen\" 1")) == plain);
    const Error error = import_test::error_of("Film \"rgb\" \"float exposuretime\" 0\nWorldBegin\n");
    CHECK(error.line == 1);
    CHECK(contains(error.message, "expected seconds above 0"));
}

TEST_CASE("white balance turns daylight into a film's white, by name or by sensor", "[film]") {
    const auto white = [](const std::string& film, const std::string& light) {
        const auto scene = render_test::scene_of("Film \"rgb\" \"integer xresolution\" 1 \"integer yresolution\" 1 " +
                                                 film + "\nSampler \"sobol\" \"integer pixelsamples\" 1\nWorldBegin\n" +
                                                 "LightSource \"infinite\" \"spectrum L\" \"" + light + "\"\n");
        const auto output = render_test::render_of(scene);
        const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
        return std::array<double, 3>{image[0], image[1], image[2]};
    };
    const auto balanced = white("\"float whitebalance\" 5000", "stdillum-D50");
    // D50 is daylight of 5003 K: the chromaticity of its white differs by 1e-4.
    CHECK(balanced[0] == Approx(1).epsilon(2e-3));
    CHECK(balanced[1] == Approx(1).epsilon(2e-3));
    CHECK(balanced[2] == Approx(1).epsilon(2e-3));
    const auto warm = white("", "stdillum-D50");
    CHECK(warm[0] > 1.1);
    CHECK(warm[2] < 0.8);
    const auto incandescent = white("\"float whitebalance\" 2856", "stdillum-A");
    CHECK(incandescent[0] == Approx(1).epsilon(5e-3));  // illuminant A is a blackbody of 2856 K (c2 of 1.435 cm K)
    CHECK(incandescent[2] == Approx(1).epsilon(5e-3));

    const auto scene = render_test::scene_of("Film \"rgb\"\n\"string sensor\" \"nikon_d850\"\nWorldBegin\n");
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "'nikon_d850' is applied to the colours of lights"));
    CHECK(scene.warnings[0].line == 2);
    const Error unknown = import_test::error_of("Film \"rgb\"\n\"string sensor\" \"nikon_d80\"\nWorldBegin\n");
    CHECK(unknown.line == 2);
    CHECK(contains(unknown.hint, "nikon_d8"));
    CHECK(contains(import_test::error_of("Film \"rgb\" \"float whitebalance\" 10\nWorldBegin\n").message, "25000 K"));
    CHECK(contains(import_test::error_of("Film \"rgb\" \"float iso\" 0\nWorldBegin\n").message, "'iso'"));
}

/// The recording of light with these XYZ by a camera's sensor, in XYZ of a film of `space`; 0 K: no "whitebalance".
Triple recorded(const std::string& sensor, double kelvin, const Triple& light, ColorSpace space = ColorSpace::srgb,
                double iso = 100) {
    SceneEntity film, camera;
    film.parameters.parameters = {typed::text("sensor", sensor), typed::real("iso", iso)};
    if (kelvin != 0) film.parameters.parameters.push_back(typed::real("whitebalance", kelvin));
    std::vector<Error> warnings;
    const auto matrix = read_sensor(film, camera, space, warnings);
    REQUIRE(matrix.ok());
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].hint.empty() == (kelvin == 0 || kelvin >= camera_sensor_coldest));
    return multiply(xyz_from_rgb(space), multiply(matrix->recorded, multiply(rgb_from_xyz(space), light)));
}

Triple xyz_of_blackbody(double kelvin) {
    Triple xyz = integrate_xyz(blackbody_spectrum(kelvin));
    const double y = xyz[1];
    for (double& c : xyz) c /= y;
    return xyz;
}

TEST_CASE("camera sensors record lights as in pbrt-v4", "[film]") {
    const Triple white = white_xyz(ColorSpace::srgb);
    const auto differ = [](const Triple& xyz, const Triple& expected) {  // relative to the brightest channel
        const Triple rgb = multiply(rgb_from_xyz(ColorSpace::srgb), xyz);
        double most = 0;
        for (std::size_t i = 0; i < 3; ++i) most = std::max(most, std::abs(rgb[i] - expected[i]));
        return most / std::max({expected[0], expected[1], expected[2]});
    };
    // Expected: linear sRGB by pbrt-v4's method (src/pbrt/film.h, PixelSensor) from its responses of the cameras
    // (src/pbrt/util/spectrum.cpp) and its swatches (src/pbrt/film.cpp), for D65 and two blackbodies with Y = 1.
    struct Case {
        const char* sensor;
        double kelvin;
        Triple white, at_2700, at_3500;
        bool between;  // temperatures of the table
    };
    for (const Case& each : {Case{"canon_eos_5d_mkiv",
                                  5000,
                                  {0.81435, 1.00285, 1.31155},
                                  {1.69974, 0.84419, 0.32418},
                                  {1.34628, 0.92545, 0.58293},
                                  false},
                             {"canon_eos_5d_mkiv",
                              6500,
                              {0.99205, 0.99301, 0.98525},
                              {1.95956, 0.83010, 0.22646},
                              {1.56950, 0.90965, 0.42432},
                              false},
                             {"canon_eos_5d_mkiv",
                              3200,
                              {0.37198, 1.11425, 2.46839},
                              {1.18883, 0.93608, 0.66938},
                              {0.88034, 1.02948, 1.14870},
                              true},
                             {"nikon_d850",
                              5000,
                              {0.79742, 1.01162, 1.30066},
                              {1.70238, 0.83993, 0.33084},
                              {1.34676, 0.92354, 0.58516},
                              false},
                             {"nikon_d850",
                              6500,
                              {0.98455, 0.99519, 0.98297},
                              {1.96735, 0.82258, 0.23442},
                              {1.57556, 0.90417, 0.42942},
                              false},
                             {"nikon_d850",
                              5700,
                              {0.89713, 1.00184, 1.12097},
                              {1.84105, 0.82913, 0.27673},
                              {1.46693, 0.91185, 0.49731},
                              true}}) {
        INFO(each.sensor << " at " << each.kelvin);
        // Entries are rounded to 5e-6, and the conversion to sRGB (whose rows sum to 5.3) makes that 8e-5 of XYZ that
        // sum to 3. Between the temperatures of the table the interpolation error is added, 0.13 %.
        CHECK(differ(recorded(each.sensor, each.kelvin, white), each.white) < (each.between ? 1.4e-3 : 1e-4));
        // The residuals of these cameras under these lights are up to 0.6 % of the brightest channel (0.57 % at 3200
        // K).
        CHECK(differ(recorded(each.sensor, each.kelvin, xyz_of_blackbody(2700)), each.at_2700) < 6e-3);
        CHECK(differ(recorded(each.sensor, each.kelvin, xyz_of_blackbody(3500)), each.at_3500) < 6e-3);
    }
    for (const std::string& sensor : camera_sensors()) {
        INFO(sensor);
        const Triple usual = recorded(sensor, 6500, white);
        CHECK(recorded(sensor, 0, white) == usual);  // pbrt's default
        // Nearly white: pbrt's own fit to the swatches has residuals of up to 1.7 % of XYZ (canon_eos_5d's Z).
        for (std::size_t i = 0; i < 3; ++i) CHECK(usual[i] == Approx(white[i]).epsilon(0.02));
        const Triple twice = recorded(sensor, 6500, white, ColorSpace::srgb, 200);
        for (std::size_t i = 0; i < 3; ++i) CHECK(twice[i] == Approx(2 * usual[i]));  // up to rounding
        // No jumps within the tables. At 4000 K pbrt itself jumps from a blackbody to daylight.
        for (const double kelvin : {2720.0, 3400.0, 5000.0, 9000.0, 14000.0}) {
            const Triple below = recorded(sensor, kelvin * (1 - 1e-6), white), at = recorded(sensor, kelvin, white);
            // A change of the temperature by a millionth moves the white by some millionths.
            for (std::size_t i = 0; i < 3; ++i) CHECK(below[i] == Approx(at[i]).epsilon(2e-5));
        }
        recorded(sensor, 1000, white);  // the hint
    }
    // A film with the white D60, by the same method, in XYZ; the least-squares matrix of the swatches has a residual of
    // 0.02 %.
    const Triple aces = recorded("nikon_d850", 5000, white, ColorSpace::aces2065_1);
    CHECK(aces[0] == Approx(0.92219).epsilon(2e-4));
    CHECK(aces[1] == Approx(0.98430).epsilon(2e-4));
    CHECK(aces[2] == Approx(1.27192).epsilon(2e-4));
    CHECK_FALSE(camera_sensor("nikon_d80", 6500, ColorSpace::srgb).has_value());
}

TEST_CASE("pbrt's integrators map to raylex's, with a warning about differences", "[film]") {
    const auto chosen = [](const std::string& type, std::vector<Parameter> parameters = {}) {
        SceneEntity entity;
        entity.type = type;
        entity.location = {"test.pbrt", 1, 1};
        entity.parameters.parameters = std::move(parameters);
        entity.parameters.parameters.push_back(typed::integer("maxdepth", 7));
        auto made = choose_integrator(entity, std::nullopt);
        INFO((made ? std::string() : made.error().to_string()));
        REQUIRE(made.ok());
        CHECK(made->integrator->traits().max_depth == (type == "sppm" ? 14 : 7));  // as many mirrors first
        return *std::move(made);
    };
    struct Case {
        const char *asked, *used, *says;
    };
    for (const Case& each :
         {Case{"mlt", "pssmlt", "Kelemen"}, Case{"sppm", "bdpt", "bdpt"},
          Case{"lightpath", "lighttracer", "lighttracer"}, Case{"simplepath", "path", "'light'"},
          Case{"simplevolpath", "path", "'scattering'"}, Case{"randomwalk", "path", "'scattering'"},
          Case{"ambientocclusion", "path", "not available"}, Case{"function", "path", "not available"}}) {
        const ChosenIntegrator made = chosen(each.asked);
        CHECK(made.name == each.used);
        REQUIRE(made.warnings.size() == 1);
        CHECK(contains(made.warnings[0].message, std::string("integrator '") + each.asked + "' "));
        CHECK(contains(made.warnings[0].message, each.says));
    }
    for (const char* own : {"path", "volpath", "bdpt"}) CHECK(chosen(own).warnings.empty());
    CHECK(chosen("mlt").samples_per_pixel == 100);
    CHECK(chosen("mlt", {typed::integer("mutationsperpixel", 12), typed::integer("chains", 3)}).samples_per_pixel ==
          12);
    CHECK(chosen("simplepath", {typed::boolean("samplelights", false)}).warnings[0].message.find("'scattering'") !=
          std::string::npos);
    SceneEntity none;
    none.type = "mlt";
    none.parameters.parameters = {typed::integer("mutationsperpixel", 0)};
    CHECK_FALSE(choose_integrator(none, std::nullopt).ok());
}

TEST_CASE("missing files are errors, or counted magenta placeholders", "[film][import][law7]") {
    const ImageFile image(1, 1, {Rgb(1)});
    const std::string text =
        "WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"gone.png\"\n"
        "Texture \"f\" \"float\" \"imagemap\" \"string filename\" \"gone.exr\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"t\" \"string normalmap\" \"gone2.png\"\n"
        "Shape \"plymesh\" \"string filename\" \"gone.ply\"\n"
        "LightSource \"infinite\" \"string filename\" \"sky.exr\"\n"
        "LightSource \"projection\" \"string filename\" \"slide.png\" \"float fov\" 40\n"
        "AreaLightSource \"diffuse\"" +
        image.parameter() + "\nShape \"sphere\"\n";
    const Error refused = import_test::error_of(text, "/folder/scene.pbrt");
    CHECK(refused.line == 2);
    CHECK(contains(refused.message, "gone.png"));
    CHECK(contains(refused.hint, "/folder"));
    const auto scene = import_pbrt_text(text, "/folder/scene.pbrt", {MissingFiles::placeholders});
    INFO((scene ? std::string() : scene.error().to_string()));
    REQUIRE(scene.ok());
    REQUIRE(scene->placeholders.size() == 6);
    CHECK(scene->placeholders[0] == "gone.png");
    REQUIRE(scene->warnings.size() == 6);
    CHECK(contains(scene->warnings[3].message, "gone.ply"));
    CHECK(scene->warnings[3].line == 5);
    CHECK(scene->textures[0].type == "constant");
    REQUIRE(scene->shapes.size() == 2);
    CHECK(scene->shapes[0].positions.size() == 8);
    CHECK(scene->materials[static_cast<std::size_t>(scene->shapes[0].material)].type == "diffuse");
    CHECK(scene->lights[1].type == "point");
    RenderSettings settings;
    settings.film.resolution = {{4, 4}};
    const auto output = render_test::render_of(*scene, settings);
    const std::vector<double> beauty = output.frame_buffer.resolve(output.beauty);
    CHECK(beauty[0] > 0);
    CHECK(beauty[1] == 0);  // magenta sky
    const auto lens = import_pbrt_text("Camera \"realistic\" \"string lensfile\" \"gone.dat\"\nWorldBegin\n",
                                       "/folder/scene.pbrt", {MissingFiles::placeholders});
    REQUIRE_FALSE(lens.ok());  // there is no placeholder for a lens
    CHECK(lens.error().line == 1);
}

TEST_CASE("a gbuffer film requests raylex's AOVs by its own names", "[film]") {
    SceneEntity entity;
    entity.type = "rgb";
    CHECK(gbuffer_layers(entity).empty());
    entity.type = "gbuffer";
    CHECK(gbuffer_layers(entity) == std::vector<std::string>{"albedo", "P", "Ngn", "Nn", "st"});
    entity.parameters.parameters = {typed::text("coordinatesystem", "world")};
    CHECK(gbuffer_layers(entity) == std::vector<std::string>{"albedo", "Pw", "__Nworld", "st"});
}

}  // namespace film_tests
