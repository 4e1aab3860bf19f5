// Furnace and integrating-sphere scenes: rows A to D of the table of analytic scenes, word by word.
//
// In a closed enclosure whose walls all emit Le and scatter with albedo kd (Lambert) + ks (mirror), the radiance along
// any ray is the same, so the word with #D diffuse and #S mirror events has the value Le kd^#D ks^#S.
//
// Tolerance of every closed-form comparison: 4 standard errors of the estimate (false alarm 6.3e-5 per word), plus 1e-5
// relative for float throughput products of up to 8 factors and for directions with up to 2^-20 relative error.
#include <algorithm>

#include "endtoend/analytic.h"

using namespace raylex;
using namespace raylex::test;

namespace {

constexpr double float_slack = 1e-5;

std::string box(const std::string& material, double emission) {
    const std::string le = std::to_string(emission);
    return R"(
        LookAt 0.1 0.2 0.3  0.3 0.1 -1  0 1 0
        Camera "perspective" "float fov" 60
        Film "rgb" "integer xresolution" 16 "integer yresolution" 16
        PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
        WorldBegin
        AreaLightSource "diffuse" "rgb L" [)" +
           le + " " + le + " " + le + "]\n" + material + R"(
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 1 1 -1 1 1 -1 -1 -1 -1 -1]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 1 -1 1 1 -1 1 1 1 -1 1 1]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 -1 1 -1 -1 1 -1 1 1 1 1 1]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 1 -1 -1 -1 -1 1 -1 -1 1 1]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 -1 -1 1 -1 1 1 1 1 1 1 -1]
    )";
}

std::string diffuse_mirror(double kd, double ks) {
    return "Material \"raylex:diffuse-mirror\" \"rgb diffuse\" [" + std::to_string(kd) + " " + std::to_string(kd) +
           " " + std::to_string(kd) + "] \"rgb specular\" [" + std::to_string(ks) + " " + std::to_string(ks) + " " +
           std::to_string(ks) + "]\n";
}

transport::SceneEntity path_integrator(const std::string& strategy, int max_depth, bool roulette = true) {
    transport::SceneEntity integrator;
    integrator.type = "path";
    Parameter depth;
    depth.name = "maxdepth";
    depth.type = ParameterType::integer;
    depth.numbers = {double(max_depth)};
    Parameter choice;
    choice.name = "strategy";
    choice.type = ParameterType::string;
    choice.strings = {strategy};
    Parameter survival;
    survival.name = "roulette";
    survival.type = ParameterType::boolean;
    survival.booleans = {static_cast<std::uint8_t>(roulette)};
    integrator.parameters.parameters = {depth, choice, survival};
    return integrator;
}

double word_value(const std::string& word, double le, double kd, double ks) {
    const auto diffuse = std::count(word.begin(), word.end(), 'D');
    const auto mirror = std::count(word.begin(), word.end(), 'S');
    return le * std::pow(kd, double(diffuse)) * std::pow(ks, double(mirror));
}

void check_path_strings(const transport::SceneDescription& scene, double le, double kd, double ks, std::size_t longest,
                        std::uint64_t samples, const std::string& strategy, double largest_relative_error,
                        bool roulette = true) {
    const std::vector<std::string> expressions = words("DS", longest, "L");
    transport::RenderSettings settings;
    settings.samples.per_pixel = samples;
    settings.paths.integrator = path_integrator(strategy, int(longest) - 2, roulette);
    for (const std::string& word : expressions) settings.channels.list.push_back(lpe_channel("w" + word, word));
    const auto output = render_or_fail(scene, settings);
    double worst = 0;
    for (std::size_t i = 0; i < expressions.size(); ++i) {
        const Estimate estimate = image_mean(output, requested(output, i));
        const double expected = word_value(expressions[i], le, kd, ks);
        CAPTURE(expressions[i], expected, estimate.mean, estimate.standard_error);
        CHECK(std::abs(estimate.mean - expected) <= 4 * estimate.standard_error + float_slack * expected);
        worst = std::max(worst, estimate.standard_error / expected);
    }
    CAPTURE(worst);
    CHECK(worst <= largest_relative_error);
}

}  // namespace

TEST_CASE("Row A: in a closed diffuse and mirror enclosure every word has the value Le kd^#D ks^#S",
          "[furnace][statistical][gate]") {
    const auto scene = import_text(box(diffuse_mirror(0.5, 0.3), 1.0));
    // Short: 16 x 16 x 1024 samples. The rarest word of length 6, SSSS, has probability above 1/256 per path, so its
    // relative standard error is below sqrt(256 / 262144) = 3.2 %.
    check_path_strings(scene, 1.0, 0.5, 0.3, 6, 1024, "scattering", 0.032);
    check_path_strings(scene, 1.0, 0.5, 0.3, 5, 1024, "mis", 0.032);
}

TEST_CASE("Row A: regular expressions over the enclosure's words sum as geometric series",
          "[furnace][statistical][gate]") {
    const auto scene = import_text(box(diffuse_mirror(0.5, 0.3), 1.0));
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1024;
    settings.paths.integrator = path_integrator("scattering", 40);
    settings.channels.list = {lpe_channel("all", "C[DS]*L"), lpe_channel("caustic", "CDS+L"),
                              lpe_channel("even", "C(S*DS*D)*S*L"), lpe_channel("dsd", "CDSDL")};
    const auto output = render_or_fail(scene, settings);
    // Truncation after 40 events leaves 5 * 0.8^41 = 5e-4 of the whole and of the even words; the others are exact.
    const double tail = 5 * std::pow(0.8, 41);
    const double expected[] = {5.0, 0.5 * 0.3 / 0.7, 2.916667, 0.075};
    const double truncation[] = {tail, 0.5 * std::pow(0.3, 40) / 0.7, tail, 0.0};
    for (std::size_t i = 0; i < 4; ++i) {
        const Estimate estimate = image_mean(output, requested(output, i));
        CAPTURE(i, expected[i], estimate.mean, estimate.standard_error);
        // 2.916667 is itself rounded to 6 decimals: 5e-7.
        CHECK(std::abs(estimate.mean - expected[i]) <=
              4 * estimate.standard_error + truncation[i] + float_slack * expected[i] + 5e-7);
    }
    const Estimate beauty = image_mean(output, output.beauty);
    CHECK(std::abs(beauty.mean - 5.0) <= 4 * beauty.standard_error + tail + 5 * float_slack);
}

TEST_CASE("Row A in full: every word up to length 8 within 0.1 % standard error", "[.full][furnace][gate]") {
    // kd = ks, so one path in 64 meets each of the 64 words of length 8, always with the same value. The relative
    // standard error is sqrt(63 / N), 9.1e-4 for N = 256 x 300000. Roulette would only add noise.
    check_path_strings(import_text(box(diffuse_mirror(0.4, 0.4), 1.0)), 1.0, 0.4, 0.4, 8, 300'000, "scattering", 1e-3,
                       false);
}

TEST_CASE("Row B: a point light in the centre of a Lambert sphere gives I rho^k / (pi R^2)", "[furnace]") {
    const auto scene = import_text(R"(
        LookAt 0.2 -0.3 0.4  1 0.2 -1  0 1 0
        Camera "perspective" "float fov" 70
        Film "rgb" "integer xresolution" 16 "integer yresolution" 16
        PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
        WorldBegin
        LightSource "point" "rgb I" [3.14159265 3.14159265 3.14159265]
        Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
        Shape "sphere" "float radius" 1
    )");
    const std::vector<std::string> expressions = words("D", 8, "L");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.paths.integrator = path_integrator("mis", 6);
    for (const std::string& word : expressions) settings.channels.list.push_back(lpe_channel("w" + word, word));
    const auto output = render_or_fail(scene, settings);
    for (std::size_t i = 0; i < expressions.size(); ++i) {
        const Estimate estimate = image_mean(output, requested(output, i));
        const double expected = i == 0 ? 0.0 : std::pow(0.5, double(i));
        CAPTURE(expressions[i], expected, estimate.mean, estimate.standard_error);
        CHECK(std::abs(estimate.mean - expected) <= 4 * estimate.standard_error + 2 * float_slack * expected);
        if (i == 0) CHECK(estimate.mean == 0.0);
        // Every vertex has the same irradiance, so only Russian roulette (survival 1/2 from the second bounce) makes
        // noise. Var of the word D^k is at most value^2 (2^(k-1) - 1) per sample; 16384 samples.
        const double most = expected * std::sqrt((std::pow(2.0, double(i)) + 1) / 16384.0);
        CHECK(estimate.standard_error <= most + float_slack * expected);
    }
}

namespace {

void check_integrating_sphere(std::uint64_t samples, double largest_relative_error, bool roulette = true) {
    auto scene = import_text(R"(
        LookAt 0.1 -0.2 0.05  1 0.3 -0.1  0 0 1
        Camera "perspective" "float fov" 40
        Film "rgb" "integer xresolution" 16 "integer yresolution" 16
        PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
        WorldBegin
        Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
        ReverseOrientation
        Shape "sphere" "float radius" 1 "float zmin" -0.8 "float zmax" 0.6
        AttributeBegin
          AreaLightSource "diffuse" "rgb L" [2 2 2]
          Shape "sphere" "float radius" 1 "float zmin" 0.6 "float zmax" 1
        AttributeEnd
        AttributeBegin
          AreaLightSource "diffuse" "rgb L" [5 5 5]
          Shape "sphere" "float radius" 1 "float zmin" -1 "float zmax" -0.8
        AttributeEnd
    )");
    REQUIRE(scene.area_lights.size() == 2);
    scene.area_lights[0].group = "a";
    scene.area_lights[1].group = "b";
    // Area fraction of a cap of height h on the unit sphere is h / 2 (Archimedes).
    const double emitted[] = {2 * 0.2, 5 * 0.1};
    const char* group[] = {"a", "b"};
    transport::RenderSettings settings;
    settings.samples.per_pixel = samples;
    settings.paths.integrator = path_integrator("mis", 6, roulette);
    for (const char* name : group)
        for (int k = 1; k <= 6; ++k)
            settings.channels.list.push_back(
                lpe_channel(std::string(name) + std::to_string(k), "CD{" + std::to_string(k) + "}<L.'" + name + "'>"));
    const auto output = render_or_fail(scene, settings);
    for (std::size_t i = 0; i < settings.channels.list.size(); ++i) {
        const Estimate estimate = image_mean(output, requested(output, i));
        const double expected = emitted[i / 6] * std::pow(0.6, double(i % 6 + 1));
        CAPTURE(settings.channels.list[i].name, expected, estimate.mean, estimate.standard_error);
        CHECK(std::abs(estimate.mean - expected) <= 4 * estimate.standard_error + 2 * float_slack * expected);
        CHECK(estimate.standard_error <= largest_relative_error * expected);
    }
}

}  // namespace

TEST_CASE("Row C: in an integrating sphere each patch gives rho^k f Le at every pixel", "[furnace][statistical]") {
    check_integrating_sphere(256, 0.03);
}

TEST_CASE("Row C in full: 0.1 % standard error for every word up to length 8", "[.full][furnace]") {
    check_integrating_sphere(32768, 1e-3, false);
}

namespace {

void check_closed_box(std::uint64_t samples, double largest_relative_error, bool roulette = true) {
    const auto scene = import_text(box("Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]\n", 1.0));
    const std::vector<std::string> expressions = words("D", 8, "L");
    transport::RenderSettings settings;
    settings.samples.per_pixel = samples;
    settings.paths.integrator = path_integrator("mis", 6, roulette);
    for (const std::string& word : expressions) settings.channels.list.push_back(lpe_channel("w" + word, word));
    const auto output = render_or_fail(scene, settings);
    for (std::size_t i = 0; i < expressions.size(); ++i) {
        const Estimate estimate = image_mean(output, requested(output, i));
        const double expected = std::pow(0.5, double(i));
        CAPTURE(expressions[i], expected, estimate.mean, estimate.standard_error);
        CHECK(std::abs(estimate.mean - expected) <= 4 * estimate.standard_error + float_slack * expected);
        CHECK(estimate.standard_error <= largest_relative_error * expected);
    }
}

}  // namespace

TEST_CASE("Row D: in a closed box that emits everywhere the word D^k has the value Le rho^k",
          "[furnace][statistical]") {
    check_closed_box(256, 0.08);
}

TEST_CASE("Row D in full: 0.1 % standard error for every word up to length 8", "[.full][furnace]") {
    check_closed_box(32768, 1e-3, false);
}
