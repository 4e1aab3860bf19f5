// Bidirectional path tracing against the path tracer, word by word.
#include <numeric>

#include "transport/enclosure.h"

using namespace render_test;

TEST_CASE("bidirectional path tracing finds the path tracer's image, word by word",
          "[bdpt][render][statistical][gate]") {
    transport::RenderSettings settings;
    settings.paths.max_depth = 4;
    settings.samples.per_pixel = 256;
    settings.film.resolution = {{18, 18}};
    compare_with_path(room, settings, integrator_named("bdpt"), 12, 128,
                      {"C<.[DG]>L", "C<.[DG]>B", "CL", "C<RD><.S>+L", "C<.S>+<RD>L", "C<RD><RD>+[LB]", "C<RG>.*L",
                       "C<.S>.*[LB]", "C<RD><.G>.*[LB]", "C.*[LB]"});
}

TEST_CASE("bidirectional path tracing through lenses and cutouts, with shading normals and every kind of light",
          "[bdpt][render][statistical][gate]") {
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.samples.per_pixel = 256;
    // What only light subpaths find (a mirror's caustic of the spot light) has no counterpart and is left out.
    compare_with_path(many_lights(), settings, integrator_named("bdpt"), 12, 256,
                      {"C<RD>[LB]", "C<Ts><RD>[LB]", "C<RD><RS>+B", "C<RS>.*[LB]", "C<RG>[LB]", "C<RD><.G>+[LB]",
                       "C<RD><RD>[LB]", "C<Ts>*[LB]"});
}

/// A ball of fog before the camera: a light in it without a border of its own, one inside a ball of another medium, one
/// on that ball's border, and a sky and a point light outside. Lights without extent in fog, and a camera there, would
/// give light samples and splats an infinite variance, about which seeds say nothing.
const std::string fog_box = plain_film + R"(
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.05 0.1 0.2] "rgb sigma_s" [0.4 0.3 0.2] "float g" 0.3
MakeNamedMedium "milk" "string type" "homogeneous" "rgb sigma_a" [0.1 0.1 0.1] "rgb sigma_s" [2 2.5 3] "float g" -0.2
LookAt 0 0.8 5.5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [0.4 0.4 0.4]
LightSource "point" "rgb I" [10 10 10] "point3 from" [0 5 2]
AttributeBegin
  MediumInterface "fog" ""
  Material "interface"
  Shape "sphere" "float radius" 3
AttributeEnd
Material "diffuse" "rgb reflectance" [0.7 0.7 0.7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -1 2 2 -1 2 2 -1 -2 -2 -1 -2]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [5 5 5]
  Translate -1.2 1 0
  Shape "sphere" "float radius" 0.3
AttributeEnd
AttributeBegin
  Translate 0.8 -0.2 0
  MediumInterface "milk" "fog"
  Material "interface"
  AreaLightSource "diffuse" "rgb L" [0.5 0.5 0.5]
  Shape "sphere" "float radius" 0.6
AttributeEnd
AttributeBegin
  Translate 0.8 -0.2 0
  AreaLightSource "diffuse" "rgb L" [4 4 4]
  Shape "sphere" "float radius" 0.2
AttributeEnd
)";

TEST_CASE("methods that begin at the lights find the path tracer's image in media, word by word",
          "[bdpt][lighttracer][render][media][statistical][gate]") {
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    transport::RenderSettings settings;
    settings.paths.max_depth = 4;
    settings.samples.per_pixel = 192;
    // Borders of media leave the event Ts.
    const std::vector<std::string> words = {
        "C<Ts>VL",      "C<Ts><Ts><V.'milk'>L", "C<Ts>VVL",       "C<Ts><V.'fog'><Ts><V.'milk'>.*L",
        "C<Ts>V<Ts>B",  "C<Ts><RD>L",           "C<Ts><RD><Ts>L", "C<Ts><RD>V<Ts>*L",
        "C<Ts>VV<Ts>B", "C<Ts><RD>V.*B",        "C<Ts>+L",        "C.*L",
        "C.*B"};
    compare_with_path(fog_box, settings, integrator_named(integrator), 12, 192, words);
}

TEST_CASE("with countmirrors off a mirror shows what is seen without it", "[bdpt][render]") {
    // A white furnace of albedo 0.5 and emission 1 seen in a mirror of 0.999: 0.999 (1 + 0.5 + 0.25) by two scatterings
    // behind it, one with the mirror counted. The emission seen in it is without noise, what scatters not.
    const std::string seen = plain_film + R"(
Integrator "bdpt" "integer maxdepth" 2
LookAt 0 0 0  0 0 1  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
AttributeBegin
Material "conductor" "rgb reflectance" [.999 .999 .999]
Shape "bilinearmesh" "point3 P" [-1 -1 2  1 -1 2  -1 1 2  1 1 2]
AttributeEnd
Material "diffuse" "rgb reflectance" [.5 .5 .5]
AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
Shape "sphere" "float radius" 50)";
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.film.resolution = {{12, 12}};
    for (const bool counts : {true, false}) {
        transport::SceneDescription scene = scene_of(seen);
        scene.integrator.parameters.parameters.push_back(flag_parameter("countmirrors", counts));
        double mean = 0;  // of green; splats have no variance of a pixel's own
        const std::vector<double> values = render_of(scene, settings).frame_buffer.resolve(0);
        for (std::size_t i = 1; i < values.size(); i += 3) mean += 3 * values[i] / static_cast<double>(values.size());
        CAPTURE(counts, mean);
        // The mirror hides 1e-4 of the sphere; 144 x 64 samples of light that varies by less than itself, three times.
        CHECK(std::abs(mean - 0.999 * (counts ? 1.5 : 1.75)) < 3 * 0.6 / std::sqrt(144 * 64));
    }
}

TEST_CASE("bidirectional path tracing gives prefixes, holdouts and user events what the path tracer gives them",
          "[bdpt][render][prefixes][statistical][gate]") {
    transport::SceneDescription scene = scene_of(room);
    for (std::size_t i = 0; i < scene.shapes.size(); ++i) scene.shapes[i].holdout = i == 0;
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.samples.per_pixel = 192;
    settings.film.resolution = {{18, 18}};
    for (const char* expression :
         {"holdouts;C.*", "holdouts;C<RD><.S>+L", "C.*", "unoccluded;C.*", "holdouts;shadows;C[DS]+<L.>",
          "nothruput;C.*", "holdouts;noinfinitecheck;C.*", "CU2L", "CDU2L", "CU6L", "unoccluded;C.*<.S>[LB]"}) {
        settings.channels.list.push_back(lpe_channel("c" + std::to_string(settings.channels.list.size()), expression));
        settings.channels.list.back().statistics = false;
    }
    compare_with_path(scene, settings, integrator_named("bdpt"), 12, 128);
}

TEST_CASE("light that only mirrors show is unoccluded's, whatever else bidirectional path tracing is asked for",
          "[bdpt][render][prefixes][pruning]") {
    const auto scene = scene_of(plain_film + R"(
Camera "perspective" "float fov" 60
WorldBegin
AttributeBegin
  Material "conductor" "float roughness" 0
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 2 1 -1 2 1 1 2 -1 1 2]
AttributeEnd
Material "diffuse"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 -1 -3 3 -1 -3 3 -1 3 -3 -1 3]
AreaLightSource "diffuse" "rgb L" [2 2 2] "bool twosided" true
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1]
)");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("mirrored", "unoccluded;C<.S>L")};
    const auto mirrored = [&](const char* integrator) {
        settings.paths.integrator = integrator_named(integrator);
        return render_of(scene, settings).frame_buffer.resolve(0);
    };
    const std::vector<double> expected = mirrored("path");
    CHECK(*std::max_element(expected.begin(), expected.end()) > 1);
    CHECK(mirrored("bdpt") == expected);
    settings.channels.list.push_back(lpe_channel("lit", "C<RD>L"));  // light samples find the lamp too
    CHECK(mirrored("bdpt") == expected);
    settings.paths.prune = false;
    CHECK(mirrored("bdpt") == expected);
}

TEST_CASE("light subpaths whose vertices would take too much memory are cut and counted", "[bdpt][render]") {
    // Light that never leaves a white ball, behind the camera.
    const auto scene = scene_of(plain_film + R"(
Camera "perspective"
WorldBegin
LightSource "point" "point3 from" [0 0.2 -5] "rgb I" [1 1 1]
Material "diffuse" "rgb reflectance" [1 1 1]
Translate 0 0 -5
Shape "sphere" "float radius" 1
)");
    transport::RenderSettings settings;
    settings.paths.max_depth = 20'000;
    settings.film.resolution = {{2, 2}};
    settings.samples.per_pixel = 1;
    settings.paths.integrator = integrator_named("bdpt");
    const auto cut_of = [&] {
        std::string all;
        for (const raylex::Error& warning : render_of(scene, settings).warnings) all += warning.message;
        return all;
    };
    const std::string cut = cut_of();
    INFO(cut);
    CHECK(cut.find("4 light subpaths were cut after ") != std::string::npos);
    settings.paths.max_depth = 1000;
    CHECK(cut_of().find("were cut") == std::string::npos);
}

TEST_CASE("every technique alone, unweighted, finds what all of them find together; weighted they sum to it",
          "[bdpt][render][statistical][law1][gate]") {
    // Nothing specular, so that every technique finds every word. 1 / distance^2 keeps joins' variance finite only
    // where surfaces do not meet, so the floor and the board stand apart.
    const auto scene = scene_of(plain_film + R"(
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
LookAt 0 1 4  0 0.2 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Material "diffuse" "rgb reflectance" [0.7 0.7 0.7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -1 2 2 -1 2 2 -1 -2 -2 -1 -2]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 -3 2 0 -3 2 2 -3 -2 2 -3]
AttributeBegin
  Translate 0 1.4 0
  AreaLightSource "diffuse" "rgb L" [5 5 5]
  Shape "sphere" "float radius" 0.5
AttributeEnd
)");
    auto built = transport::BuiltScene::build(scene);
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.paths.max_depth = 2;
    settings.machine.threads = 2;
    settings.samples.per_pixel = 128;
    settings.paths.integrator = integrator_named("bdpt");
    struct Case {
        std::string words;
        std::vector<std::string> techniques;
    };
    for (const Case& each : {Case{"C.L", {"s0t3", "s1t2", "s2t1"}}, Case{"C..L", {"s0t4", "s1t3", "s2t2", "s3t1"}}}) {
        settings.channels.list.clear();
        const auto add = [&](const std::string& expression) {
            settings.channels.list.push_back(
                lpe_channel("c" + std::to_string(settings.channels.list.size()), expression));
            settings.channels.list.back().statistics = false;
        };
        add(each.words);
        for (const std::string& technique : each.techniques) add(technique + ";" + each.words);
        for (const std::string& technique : each.techniques) add(technique + ";unweighted;" + each.words);
        settings.channels.beauty = false;
        const int channels = static_cast<int>(settings.channels.list.size());
        const Replicates together = replicates(**built, settings, channels, 12, 40);
        const Replicates alone = replicates(**built, settings, channels, 12, 80);
        constexpr std::size_t blocks = blocks_across * blocks_across;
        const std::size_t techniques = each.techniques.size();
        Replicates whole, found;
        for (std::size_t seed = 0; seed < 12; ++seed) {
            whole.of_seed.emplace_back();
            for (std::size_t k = 0; k < techniques; ++k)
                whole.of_seed.back().insert(whole.of_seed.back().end(), together.of_seed[seed].begin(),
                                            together.of_seed[seed].begin() + blocks);
            found.of_seed.emplace_back(
                alone.of_seed[seed].begin() + static_cast<std::ptrdiff_t>((1 + techniques) * blocks),
                alone.of_seed[seed].end());
            for (std::size_t b = 0; b < blocks; ++b) {
                double sum = 0;
                for (std::size_t k = 1; k <= techniques; ++k) sum += together.of_seed[seed][k * blocks + b];
                CHECK(std::abs(sum - together.of_seed[seed][b]) <= 1e-12 * sum);  // sums of doubles
            }
        }
        check_agreement(whole, found, each.techniques);
        for (std::size_t k = 0; k < techniques; ++k) CHECK(alone.channel(1 + techniques + k).mean > 0.001);
    }
}

TEST_CASE("variances and adaptive sampling of bidirectional path tracing are of what camera samples bring",
          "[bdpt][render][statistical][law7][gate]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.machine.threads = 2;
    settings.samples.per_pixel = 64;
    settings.film.resolution = {{18, 18}};
    settings.paths.integrator = integrator_named("bdpt");
    for (const char* splatted : {"s2t1;C.*", "s3t1;C.*", "s4t1;C.*"})
        settings.channels.list.push_back(lpe_channel("c" + std::to_string(settings.channels.list.size()), splatted));
    settings.channels.statistics = {*display::parse_statistic_request("beauty", "mse", {"job.toml", 3, 1})};
    constexpr int seeds = 16;
    std::vector<double> sum, squares, said;
    for (int seed = 0; seed < seeds; ++seed) {
        settings.samples.seed = 300 + static_cast<std::uint64_t>(seed);
        const auto output = render_of(scene, settings);
        REQUIRE(output.warnings.size() == 1);
        CHECK(output.warnings[0].to_string().find("job.toml:3:1") != std::string::npos);
        std::vector<double> mine = output.frame_buffer.resolve(0);
        for (display::ChannelId id = 1; id <= 3; ++id) {
            const std::vector<double> splats = output.frame_buffer.resolve(id);
            CHECK(std::any_of(splats.begin(), splats.end(), [](double v) { return v > 0; }));
            for (std::size_t i = 0; i < mine.size(); ++i) mine[i] -= splats[i];
        }
        sum.resize(mine.size());
        squares.resize(mine.size());
        said.resize(mine.size());
        const std::vector<double> mse = output.frame_buffer.resolve(4);
        for (std::size_t i = 0; i < mine.size(); ++i) {
            sum[i] += mine[i];
            squares[i] += mine[i] * mine[i];
            said[i] += mse[i] / seeds;
        }
    }
    double found = 0, expected = 0, scatter = 0;
    for (std::size_t i = 1; i < sum.size(); i += 3) {
        const double variance = (squares[i] - sum[i] * sum[i] / seeds) / (seeds - 1);
        found += variance;
        expected += said[i];
        scatter += 2 * variance * variance / (seeds - 1);
    }
    CAPTURE(found, expected);
    CHECK(expected > 0);
    CHECK(std::abs(found - expected) < 5 * std::sqrt(scatter));  // of a sum of variances of nearly normal means
    CHECK(5 * std::sqrt(scatter) < 0.7 * expected);

    const auto error = [&] {
        const auto output = transport::render(scene, settings);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.channels.statistics = {*display::parse_statistic_request("beauty", "even", {"job.toml", 3, 1})};
    CHECK(error().find("has no halves of 'beauty'") != std::string::npos);
    settings.channels.statistics.clear();
    settings.channels.list.clear();
    settings.samples.seed = 0;
    settings.samples.per_pixel = 512;
    const auto plain = render_of(scene, settings);
    settings.stop.adaptive.emplace();
    settings.stop.adaptive->error = 0.1;
    settings.stop.adaptive->max_samples = 512;
    const auto adaptive = render_of(scene, settings);
    REQUIRE(adaptive.warnings.size() == 1);
    CHECK(adaptive.warnings[0].message.find("the error of camera samples only") != std::string::npos);
    CHECK(adaptive.statistics.camera_samples < plain.statistics.camera_samples);
    CHECK(adaptive.statistics.camera_samples > plain.statistics.camera_samples / 50);
    // The pixels' errors are at most about a tenth, so their mean's is far below.
    const auto mean = [](const transport::RenderOutput& output) {
        const std::vector<double> image = output.frame_buffer.resolve(0);
        return std::accumulate(image.begin(), image.end(), 0.0) / static_cast<double>(image.size());
    };
    CHECK(mean(adaptive) == Approx(mean(plain)).epsilon(0.04));
}

TEST_CASE("in an emitting enclosure every word has its closed form with every integrator",
          "[bdpt][lighttracer][pssmlt][render][statistical][gate]") {
    auto built = transport::BuiltScene::build(scene_of(enclosure(0.5, 0.3)));
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.paths.max_depth = 5;
    settings.channels.beauty = false;
    settings.machine.threads = 2;
    const std::string integrator = GENERATE("path", "bdpt", "lighttracer", "pssmlt");
    CAPTURE(integrator);
    settings.paths.integrator = integrator_named(integrator);
    std::vector<ClosedForm> expected;
    for (const EnclosurePathString& word : enclosure_path_strings(0.5, 0.3, 5)) {
        const bool found = integrator != "lighttracer" || light_tracer_finds(word);
        expected.push_back({"C" + word.reflections + "L", found ? word.value : 0});
        settings.channels.list.push_back(osl("w" + std::to_string(expected.size()), expected.back().expression));
    }
    settings.samples.per_pixel =
        integrator == "lighttracer" ? 256 : 64;  // mirrors that light paths meet are rare words
    check_closed_forms(replicates(**built, settings, static_cast<int>(expected.size()), 16, 900), expected,
                       4 * expected.size(), 0.12);
}
