// Indices of refraction that depend on the wavelength: closed forms of slabs and prisms, integrators against one
// another, laws. pbrt-v4 is met through the closed forms alone: its white light has the spectrum that they integrate.
#include "transport/replicates.h"

#include <array>
#include <numeric>

#include "transport/color/color_space.h"
#include "transport/color/wavelengths.h"
#include "transport/math/fresnel.h"

using namespace render_test;
using namespace raylex::transport;

namespace {

/// What 1 nm around each visible sample adds to the RGB of white light.
std::vector<std::array<double, 3>> white_by_wavelength() {
    VisibleSpectrum white{};
    REQUIRE(find_named_spectrum("stdillum-D65", white));
    const MatchingFunctions& f = matching_functions();
    double luminance = 0;
    for (std::size_t i = 0; i < visible_samples; ++i) luminance += f.y[i] * white[i];
    std::vector<std::array<double, 3>> result;
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const double w = white[i] / luminance;
        result.push_back(multiply(rgb_from_xyz(ColorSpace::srgb), Triple{f.x[i] * w, f.y[i] * w, f.z[i] * w}));
    }
    return result;
}

VisibleSpectrum flint_index() {
    VisibleSpectrum index{};
    REQUIRE(find_named_spectrum("glass-F11", index));
    return index;
}

double fresnel_share(double cosine, double index) {
    return static_cast<double>(fresnel_dielectric(static_cast<Real>(cosine), static_cast<Real>(index)));
}

// A beam in the plane of x and y meets the two faces of a prism of flint, and then a wall. The faces are all there is
// of the prism, and the first is its own aperture.
constexpr double apex = 0.7, half_width = 0.02, wall_x = 1, rows_bottom = -0.83, rows_top = -0.63;
constexpr int row_count = 20;

struct Point2 {
    double x, y;
};
double dot2(Point2 a, Point2 b) {
    return a.x * b.x + a.y * b.y;
}
Point2 bent(Point2 d, Point2 normal, double eta) {  // normal against d; eta: transmitted over incident
    const double c = -dot2(d, normal), t = std::sqrt(1 - (1 - c * c) / (eta * eta));
    return {d.x / eta + normal.x * (c / eta - t), d.y / eta + normal.y * (c / eta - t)};
}
/// Where a ray meets the line through p of this normal.
Point2 met(Point2 from, Point2 d, Point2 p, Point2 normal) {
    const double t = dot2({p.x - from.x, p.y - from.y}, normal) / dot2(d, normal);
    return {from.x + t * d.x, from.y + t * d.y};
}

/// The beam comes along x at the angle of minimum deviation of the helium d line.
struct Prism {
    double incidence = std::asin(flint_index()[588 - visible_begin] * std::sin(apex / 2));
    Point2 first{-std::cos(incidence), std::sin(incidence)},
        last{std::cos(apex - incidence), std::sin(apex - incidence)},
        through{0.05, -0.015};  // a point of the second face

    struct Beam {
        double y[2];         // where its edges meet the wall
        double transmitted;  // of its power
        double deviation;
    };
    [[nodiscard]] Beam at(double index) const {
        const Point2 inside = bent({1, 0}, first, index), out = bent(inside, {-last.x, -last.y}, 1 / index);
        Beam beam{};
        for (int side = 0; side < 2; ++side) {
            const double along = side == 0 ? -half_width : half_width;
            const Point2 exit = met({-first.y * -along, -first.x * along}, inside, through, last);
            beam.y[side] = met(exit, out, {wall_x, 0}, {1, 0}).y;
        }
        beam.transmitted = (1 - fresnel_share(-first.x, index)) * (1 - fresnel_share(dot2(out, last), index));
        beam.deviation = -std::atan2(out.y, out.x);
        return beam;
    }
    [[nodiscard]] std::string face(Point2 center, Point2 normal, double half, double depth) const {
        std::string text = "Shape \"bilinearmesh\" \"point3 P\" [";
        for (const double z : {-depth, depth})  // so that the normal points outside
            for (const double s : {-half, half})
                text += std::to_string(center.x - normal.y * s) + " " + std::to_string(center.y + normal.x * s) + " " +
                        std::to_string(z) + " ";
        return text + "]\n";
    }
    [[nodiscard]] std::string scene() const {
        return R"(
Film "rgb" "integer xresolution" 4 "integer yresolution" 20
Sampler "independent" "integer pixelsamples" 64
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
LookAt 0.9 -0.73 0  1 -0.73 0  0 1 0
Camera "orthographic" "float screenwindow" [-0.02 0.02 -0.1 0.1]
WorldBegin
LightSource "distant" "rgb L" [1 1 1] "point3 from" [-1 0 0] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "bilinearmesh" "point3 P" [1 -0.9 -0.1 1 -0.5 -0.1 1 -0.9 0.1 1 -0.5 0.1]
Material "dielectric" "spectrum eta" "glass-F11"
)" + face({0, 0}, first, half_width, 0.03) +
               face(through, last, 0.1, 0.03);
    }
};

/// A closed prism of flint and a ball of the same, rough; a lamp large enough to be found by chance.
const std::string prism_room = plain_film + R"(
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
LookAt 0 1.1 4  0 0.6 0  0 1 0
Camera "perspective" "float fov" 42
WorldBegin
Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 2 2 0 2 2 0 -1 -2 0 -1]
Shape "bilinearmesh" "point3 P" [-2 0 -1 2 0 -1 -2 3 -1 2 3 -1]
AttributeBegin
  Material "dielectric" "spectrum eta" "glass-F11"
  Translate -0.5 0.5 0.2
  Rotate 20 1 0.3 0
  Shape "trianglemesh" "integer indices" [0 1 2 3 5 4 0 4 1 0 3 4 1 5 2 1 4 5 2 3 0 2 5 3]
    "point3 P" [-0.4 -0.3 0.5 0.4 -0.3 0.5 0 0.4 0.5 -0.4 -0.3 -0.5 0.4 -0.3 -0.5 0 0.4 -0.5]
AttributeEnd
AttributeBegin
  Material "dielectric" "spectrum eta" "glass-F11" "float roughness" 0.1
  Translate 0.7 0.5 0.3
  Shape "sphere" "float radius" 0.4
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 7 6]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.5 2.5 -0.5 0.5 2.5 -0.5 0.5 2.5 0.5 -0.5 2.5 0.5]
AttributeEnd
LightSource "infinite" "rgb L" [0.2 0.25 0.3]
)";

RenderSettings bounded(std::uint64_t samples) {
    RenderSettings settings;
    settings.paths.max_depth = 4;
    settings.samples.per_pixel = samples;
    return settings;
}

}  // namespace

TEST_CASE("wavelengths: drawn evenly, they count for white, each for as much as any other", "[dispersion][spectrum]") {
    ColorContext tinted;
    tinted.scene_space = ColorSpace::rec2020;
    tinted.rendering_from_scene = rgb_from_rgb(ColorSpace::aces2065_1, ColorSpace::rec2020, true);
    tinted.sensor = {{{1.2, 0.1, 0}, {0, 0.9, 0}, {0, 0.2, 0.7}}};
    for (const ColorContext& color : {ColorContext(), tinted}) {
        const WavelengthDistribution wavelengths(color);
        constexpr int count = 1 << 16;
        raylex::RgbD sum;
        double last = 0, weight = 0;
        for (int i = 0; i < count; ++i) {
            const HeroWavelength hero = wavelengths.draw((static_cast<Real>(i) + Real(0.5)) / count);
            REQUIRE(static_cast<double>(hero.nm) >= last);
            last = static_cast<double>(hero.nm);
            sum += raylex::RgbD(hero.weight);
            const double each =
                static_cast<double>(std::abs(hero.weight.r) + std::abs(hero.weight.g) + std::abs(hero.weight.b));
            if (i == 0) weight = each;
            REQUIRE(each == Approx(weight).epsilon(1e-5));  // sums of three floats
        }
        CHECK(last <= visible_end + 0.5);
        // Midpoints of 65,536 strata over a step function of 401 steps of at most 4: each step's border is off by at
        // most half a stratum.
        for (int c = 0; c < 3; ++c) CHECK(sum[c] / count == Approx(1).margin(401 * 4 * 0.5 / count));
        VisibleSpectrum flat{};
        flat.fill(1.5);
        const Rgb mean = wavelengths.mean(flat);
        for (int c = 0; c < 3; ++c) CHECK(mean[c] == Approx(1.5).epsilon(1e-6));
    }
    VisibleSpectrum line{};
    for (std::size_t i = 0; i < visible_samples; ++i) line[i] = 1 + 0.001 * static_cast<double>(i);
    const IndexSpectrum index(line, {});
    CHECK(index.at(visible_begin - 5) == 1);
    CHECK(index.at(Real(500.25)) == Approx(1.12025).epsilon(1e-6));
    CHECK(index.at(visible_end + 5) == Approx(1.4).epsilon(1e-6));
    CHECK(index.least() == 1);
    CHECK(index.most() == Approx(1.4).epsilon(1e-6));
}

TEST_CASE("dispersion: a slab under a white sky has the closed form of every word",
          "[dispersion][render][statistical][gate]") {
    const std::string slab = R"(
Film "rgb" "integer xresolution" 9 "integer yresolution" 9
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "sobol" "integer pixelsamples" 256
LookAt 1 0 -1  0 0 0  0 1 0
Camera "orthographic" "float screenwindow" [-0.1 0.1 -0.1 0.1]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "dielectric" "spectrum eta" "glass-F11"
Shape "bilinearmesh" "point3 P" [-9 -9 0  -9 9 0  9 -9 0  9 9 0]
Shape "bilinearmesh" "point3 P" [-9 -9 .5  9 -9 .5  -9 9 .5  9 9 .5]
)";
    const auto built = BuiltScene::build(scene_of(slab));
    REQUIRE(built.ok());
    const std::vector<std::array<double, 3>> white = white_by_wavelength();
    const VisibleSpectrum index = flint_index();
    for (const char* integrator : {"path", "bdpt"})
        for (std::size_t color = 0; color < 3; ++color) {
            std::array<double, 4> expected{};
            for (std::size_t i = 0; i < visible_samples; ++i) {
                const double f = fresnel_share(std::sqrt(0.5), index[i]), passed = (1 - f) * (1 - f) * white[i][color];
                expected[0] += f * white[i][color];
                for (const int inside : {0, 1, 2})
                    expected[static_cast<std::size_t>(1 + inside)] += passed * std::pow(f, inside);
            }
            RenderSettings settings = bounded(256);
            settings.paths.max_depth = 40;
            settings.channels.beauty = false;
            settings.paths.integrator = integrator_named(integrator);
            settings.paths.integrator->parameters.parameters.push_back(flag_parameter("roulette", false));
            const std::vector<ClosedForm> forms{{"C<TS><TS>B", expected[1]},
                                                {"C<TS><RS><TS>B", expected[2]},
                                                {"C<TS><RS><RS><TS>B", expected[3]},
                                                {"C.*B", 1}};
            for (const ClosedForm& each : forms)
                settings.channels.list.push_back(
                    osl("c" + std::to_string(settings.channels.list.size()), each.expression));
            settings.channels.list.push_back(osl("mirror", "C<RS>B"));
            CAPTURE(integrator, color);
            const Replicates found = replicates(**built, settings, static_cast<int>(settings.channels.list.size()), 12,
                                                7, static_cast<int>(color));
            check_closed_forms(found, forms, 2 * 3 * forms.size(), 0.05);
            // What is reflected first takes its colour from the mean index of each primary: no noise of colour, and
            // this close to the mean over the wavelengths.
            const Estimate mirror = found.channel(forms.size());
            CHECK(std::abs(mirror.mean - expected[0]) < 1e-4 * expected[0] + 4 * mirror.error);
        }
}

TEST_CASE("dispersion: a prism spreads a beam as Snell's law says, and at minimum deviation as its formula",
          "[dispersion][render][statistical][gate]") {
    const Prism prism;
    const double index = flint_index()[588 - visible_begin];
    CHECK(prism.at(index).deviation == Approx(2 * prism.incidence - apex).epsilon(1e-12));
    const VisibleSpectrum indices = flint_index();
    for (const double n : indices) CHECK(prism.at(n).deviation >= 2 * std::asin(n * std::sin(apex / 2)) - apex - 1e-12);
    // Irradiance of the wall by rows, times its reflectance over pi.
    const std::vector<std::array<double, 3>> white = white_by_wavelength();
    constexpr double height = (rows_top - rows_bottom) / row_count;
    std::vector<std::array<double, 3>> expected(row_count);
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const Prism::Beam beam = prism.at(indices[i]);
        const double low = std::min(beam.y[0], beam.y[1]), high = std::max(beam.y[0], beam.y[1]);
        REQUIRE(low > rows_bottom);
        REQUIRE(high < rows_top);
        const double power = 2 * half_width * -prism.first.x * beam.transmitted;
        for (int row = 0; row < row_count; ++row) {
            const double top = rows_top - row * height;
            const double inside = std::max(0.0, std::min(top, high) - std::max(top - height, low)) / (high - low);
            for (std::size_t c = 0; c < 3; ++c)
                expected[static_cast<std::size_t>(row)][c] +=
                    white[i][c] * power * inside / height * 0.5 / std::acos(-1.0);
        }
    }
    const auto built = BuiltScene::build(scene_of(prism.scene()));
    REQUIRE(built.ok());
    constexpr std::size_t seeds = 12;
    for (const char* integrator : {"lighttracer", "bdpt"}) {
        RenderSettings settings = bounded(4096);
        settings.channels.beauty = false;
        settings.paths.integrator = integrator_named(integrator);
        settings.channels.list = {osl("caustic", "C<RD><TS><TS>L")};
        std::vector<std::vector<double>> found(seeds);  // [seed][3 row + c]
        for (std::size_t seed = 0; seed < seeds; ++seed) {
            settings.samples.seed = 11 + seed;
            const RenderOutput output = render_of(scene_of(prism.scene()), settings);
            const std::vector<double> image = output.frame_buffer.resolve(0);
            found[seed].resize(3 * row_count);
            for (std::size_t i = 0; i < image.size(); ++i) found[seed][i / 12 * 3 + i % 3] += image[i] / 4;
        }
        const double threshold = student_threshold(seeds - 1, 2 * 3 * row_count);
        double brightest = 0, sharpest = 1;
        for (const auto& row : expected) brightest = std::max(brightest, *std::max_element(row.begin(), row.end()));
        for (std::size_t i = 0; i < found[0].size(); ++i) {
            double mean = 0, squares = 0;
            for (const auto& each : found) mean += each[i] / seeds;
            for (const auto& each : found) squares += (each[i] - mean) * (each[i] - mean);
            const double error = std::sqrt(squares / (seeds * (seeds - 1))), value = expected[i / 3][i % 3];
            CAPTURE(integrator, i / 3, i % 3, mean, error, value);
            if (std::abs(value) < 0.02 * brightest) {  // too rare for its seeds to be normal
                CHECK(std::abs(mean) < 0.1 * brightest);
                continue;
            }
            CHECK(std::abs(mean - value) <= threshold * error + 1e-4 * brightest);
            sharpest = std::min(sharpest, error / std::abs(value));
        }
        CHECK(sharpest < 0.06);  // so that the check can fail: a row more or less is a change of a third
    }
}

TEST_CASE("dispersion: an index that is the same at all wavelengths is one index, and one that hardly varies as good",
          "[dispersion][render][statistical][gate]") {
    const auto with_eta = [](const std::string& eta) {
        std::string text = room;
        const std::string glass = "Material \"dielectric\"";
        return scene_of(text.replace(text.find(glass), glass.size(), glass + " " + eta));
    };
    RenderSettings settings;
    settings.samples.per_pixel = 16;
    const auto beauty = [&](const SceneDescription& scene) {
        const RenderOutput output = render_of(scene, settings);
        return output.frame_buffer.resolve(output.beauty);
    };
    CHECK((beauty(with_eta("\"spectrum eta\" [400 1.5 700 1.5]")) == beauty(with_eta("\"float eta\" 1.5"))));
    const auto constant = BuiltScene::build(with_eta("\"float eta\" 1.5")),
               varying = BuiltScene::build(with_eta("\"spectrum eta\" [400 1.5 700 1.500001]"));
    REQUIRE(constant.ok());
    REQUIRE(varying.ok());
    REQUIRE((*varying)->view().wavelengths != nullptr);
    REQUIRE((*constant)->view().wavelengths == nullptr);
    settings.samples.per_pixel = 64;
    for (const int color : {0, 1, 2}) {
        CAPTURE(color);
        check_agreement(replicates(**constant, settings, 1, 12, 50, color),
                        replicates(**varying, settings, 1, 12, 90, color), {"beauty"});
    }
}

TEST_CASE("dispersion: bidirectional path tracing agrees with path tracing",
          "[dispersion][bdpt][render][statistical][gate]") {
    for (const int color : {0, 2})
        compare_with_path(prism_room, bounded(512), integrator_named("bdpt"), 12, 128,
                          {"C<RD><TS>.*[LB]", "C<RD><TG>.*[LB]", "C<TG>.*[LB]", "C<TS>.*[LB]", "C.*[LB]"}, color);
}

TEST_CASE("dispersion: light tracing agrees with path tracing",
          "[dispersion][light-tracer][render][statistical][gate]") {
    for (const int color : {0, 2})
        compare_with_path(prism_room, bounded(512), integrator_named("lighttracer"), 12, 512,
                          {"C<RD><TS>.*[LB]", "C<RD><TG>.*[LB]", "C<TG>.*[LB]"}, color);
}

TEST_CASE("dispersion: Metropolis light transport agrees with path tracing",
          "[dispersion][pssmlt][render][statistical][gate]") {
    compare_with_path(prism_room, bounded(256), metropolis(100, 20'000), 12, 128, {"C<TS>.*[LB]", "C.*[LB]"}, 2);
}

TEST_CASE("dispersion: splits sum to the beauty, which does not know of them, for any number of threads",
          "[dispersion][render][law1][law2][law3]") {
    const SceneDescription scene = scene_of(prism_room);
    for (const char* integrator : {"path", "bdpt", "lighttracer"}) {
        CAPTURE(integrator);
        RenderSettings settings = bounded(16);
        settings.paths.integrator = integrator_named(integrator);
        settings.machine.threads = 1;
        const RenderOutput alone = render_of(scene, settings);
        const std::vector<double> beauty = alone.frame_buffer.resolve(alone.beauty);
        for (const char* each : {"C[LB]", "C<R.>.*[LB]", "C<TS>.*[LB]", "C<TG>.*[LB]"})
            settings.channels.list.push_back(osl("c" + std::to_string(settings.channels.list.size()), each));
        settings.machine.threads = 3;
        const RenderOutput split = render_of(scene, settings);
        CHECK((split.frame_buffer.resolve(split.beauty) == beauty));
        std::vector<double> sum(beauty.size()), magnitude(beauty.size());
        for (display::ChannelId id = 1; id <= 4; ++id) {
            const std::vector<double> layer = split.frame_buffer.resolve(id);
            for (std::size_t i = 0; i < sum.size(); ++i) {
                sum[i] += layer[i];
                magnitude[i] += std::abs(layer[i]);
            }
        }
        bool negative = false;
        double worst = 0;
        for (std::size_t i = 0; i < sum.size(); ++i) {
            negative = negative || beauty[i] < 0;
            if (magnitude[i] > 0) worst = std::max(worst, std::abs(sum[i] - beauty[i]) / magnitude[i]);
        }
        CHECK(worst <= 1e-12);                                   // Law 1's bound for the double accumulators
        if (integrator == std::string("path")) CHECK(negative);  // of so few samples: colours outside of the space
    }
}

TEST_CASE("dispersion: words are those of glass of one index", "[dispersion][law4]") {
    for (const char* more :
         {"", " \"float roughness\" 0.3", " \"float roughness\" 0.3 \"bool raylex:compensate\" true"}) {
        const auto lobes_of = [&](const std::string& eta) {
            const SceneDescription scene =
                scene_of("WorldBegin Material \"dielectric\" " + eta + more + " Shape \"sphere\"");
            auto textures = TextureTable::build(scene);
            REQUIRE(textures.ok());
            const auto materials = MaterialTable::build(scene, *textures);
            REQUIRE(materials.ok());
            std::vector<LobeId> lobes;
            materials->material(static_cast<std::size_t>(scene.shapes.front().material))->append_lobes(lobes);
            return lobes;
        };
        CHECK((lobes_of("\"spectrum eta\" \"glass-F11\"") == lobes_of("\"float eta\" 1.78")));
    }
    const raylex::Error error = [] {
        const auto built = BuiltScene::build(
            scene_of("WorldBegin\nMaterial \"dielectric\" \"spectrum eta\" [400 1.5 700 0]\nShape \"sphere\""));
        REQUIRE_FALSE(built.ok());
        return built.error();
    }();
    CHECK(error.line == 2);
    CHECK(error.message.find("expected indices of refraction above 0") != std::string::npos);
}
