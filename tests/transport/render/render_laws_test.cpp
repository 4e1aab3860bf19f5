// The laws of the design, in one small room that contains every kind of event.
#include "transport/render_support.h"

#include <algorithm>
#include <atomic>

using namespace render_test;

namespace {

std::vector<double> beauty_of(const transport::RenderOutput& output) {
    return output.frame_buffer.resolve(output.beauty);
}

std::vector<display::ChannelDefinition> shipped_partition() {
    return {lpe_channel("emissive", "C[<L.>O]-CB"),
            lpe_channel("background", "CB"),
            lpe_channel("directDiffuse", "C<RD>[<L.>O]"),
            lpe_channel("indirectDiffuse", "C<RD>[DSV]+[<L.>O]"),
            lpe_channel("subsurface", "C<TD>[DSV]*[<L.>O]"),
            lpe_channel("directSpecular", "C<RS>[<L.>O]"),
            lpe_channel("indirectSpecular", "C<RS>[DSV]+[<L.>O]"),
            lpe_channel("transmissive", "C<TS>[DSV]*[<L.>O]"),
            lpe_channel("volume", "CV.*")};
}

}  // namespace

TEST_CASE("the shipped partition sums to beauty in every pixel", "[render][law1]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.list = shipped_partition();
    const auto output = render_of(scene_of(room), settings);
    const std::vector<double> beauty = beauty_of(output);
    std::vector<double> sum(beauty.size()), magnitude(beauty.size());
    for (display::ChannelId id = 1; id <= static_cast<display::ChannelId>(settings.channels.list.size()); ++id) {
        const std::vector<double> layer = output.frame_buffer.resolve(id);
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += layer[i];
            magnitude[i] += std::abs(layer[i]);
        }
    }
    double worst = 0, total = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        total += beauty[i];
        if (magnitude[i] + std::abs(beauty[i]) > 0)
            worst = std::max(worst, std::abs(sum[i] - beauty[i]) / (magnitude[i] + std::abs(beauty[i])));
    }
    CHECK(total > 0);
    CHECK(worst <= 1e-12);  // Law 1's bound for the double accumulators
}

TEST_CASE("beauty is bit-identical with 0, 8 and 64 channels and geometric AOVs", "[render][law2]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    const std::vector<double> alone = beauty_of(render_of(scene, settings));
    settings.channels.list = shipped_partition();
    CHECK(beauty_of(render_of(scene, settings)) == alone);
    settings.channels.list.clear();
    for (int i = 0; i < 64; ++i) {
        std::string expression = "C";
        for (int bit = 0; bit < 6; ++bit) expression += i >> bit & 1 ? "D" : "S?";
        settings.channels.list.push_back(
            lpe_channel(std::string("c").append(std::to_string(i)), expression + "[<L.>O]"));
    }
    for (const char* name : {"Nn", "z", "albedo"}) {
        display::ChannelDefinition aov;
        aov.name = name;
        settings.channels.list.push_back(aov);
    }
    CHECK(beauty_of(render_of(scene, settings)) == alone);
    settings.labels.picked_lobes = true;
    CHECK(beauty_of(render_of(scene, settings)) == alone);
}

TEST_CASE("images are bit-identical for any number of threads, and on a rerun", "[render][law3]") {
    const auto scene = scene_of(room);
    auto built = transport::BuiltScene::build(scene);
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.samples.per_pixel = 20;  // a whole block and a partial one
    settings.channels.list = {lpe_channel("specular", "C<RS>.*"), lpe_channel("diffuse", "C<RD>.*")};
    settings.machine.threads = 1;
    auto one = transport::render(**built, settings);
    REQUIRE(one.ok());
    settings.machine.threads = 3;
    auto three = transport::render(**built, settings);
    REQUIRE(three.ok());
    const auto fresh = render_of(scene, settings);
    for (display::ChannelId id = 0; id < 3; ++id) {
        CHECK(one->frame_buffer.resolve(id) == three->frame_buffer.resolve(id));
        CHECK(one->frame_buffer.resolve(id) == fresh.frame_buffer.resolve(id));
    }
    settings.samples.seed = 1;
    auto other = transport::render(**built, settings);
    REQUIRE(other.ok());
    CHECK(one->frame_buffer.resolve(0) != other->frame_buffer.resolve(0));
}

TEST_CASE("without a beauty the channels have the same bits with fewer rays", "[render][law4]") {
    // Without coats: of a coat and its base, the one that no channel accepts is omitted, which changes densities.
    std::string text = room;
    const std::string coated = R"("coateddiffuse" "rgb reflectance" [0.2 0.5 0.7] "float roughness" 0.05)";
    text.replace(text.find(coated), coated.size(), R"("diffuse" "rgb reflectance" [0.2 0.5 0.7])");
    const auto scene = scene_of(text);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.list = {lpe_channel("direct", "C<RD>[<L.>O]"), lpe_channel("background", "CB")};
    const auto full = render_of(scene, settings);
    settings.channels.beauty = false;
    const auto pruned = render_of(scene, settings);
    CHECK(pruned.beauty == display::invalid_channel);
    for (display::ChannelId id = 0; id < 2; ++id)
        CHECK(pruned.frame_buffer.resolve(id) == full.frame_buffer.resolve(id + 1));
    CHECK(pruned.statistics.scattering_rays * 2 < full.statistics.scattering_rays);
    CHECK(pruned.statistics.shadow_rays * 2 < full.statistics.shadow_rays);
}

TEST_CASE("each lobe's channel equals a render with only that lobe, with at most the variance of picking",
          "[render][law5]") {
    const auto surface = [](const std::string& diffuse, const std::string& specular) {
        return scene_of(film + R"(
Integrator "path" "integer maxdepth" 1
LookAt 0 2 4  0 0 0  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
AttributeBegin
  Translate 0 1.5 -2
  AreaLightSource "diffuse" "rgb L" [4 4 4]
  Shape "sphere" "float radius" 0.5
AttributeEnd
LightSource "infinite" "rgb L" [0.3 0.3 0.3]
Material "raylex:additive" "float roughness" 0.3 "bool remaproughness" false "rgb diffuse" [)" +
                        diffuse + "] \"rgb specular\" [" + specular + R"(]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-5 0 5 5 0 5 5 0 -5 -5 0 -5]
)");
    };
    transport::RenderSettings settings;
    settings.samples.per_pixel = 256;
    settings.channels.list = {lpe_channel("d", "C<RD>[<L.>O]"), lpe_channel("s", "C<RS>[<L.>O]")};
    const auto both = render_of(surface("0.4 0.5 0.3", "0.6 0.5 0.4"), settings);
    settings.labels.picked_lobes = true;
    const auto picked = render_of(surface("0.4 0.5 0.3", "0.6 0.5 0.4"), settings);
    settings.labels.picked_lobes = false;
    settings.samples.seed = 99;  // independent of the render above, as the deviation below assumes
    const auto diffuse = render_of(surface("0.4 0.5 0.3", "0 0 0"), settings);
    const auto specular = render_of(surface("0 0 0", "0.6 0.5 0.4"), settings);
    const Estimate d = estimate(both, 1), s = estimate(both, 2);
    INFO("diffuse " << d.mean << " +- " << d.error << " alone " << estimate(diffuse).mean << " specular " << s.mean
                    << " +- " << s.error << " alone " << estimate(specular).mean);
    CHECK(deviation(d, estimate(diffuse)) < 4.5);
    CHECK(deviation(s, estimate(specular)) < 4.5);
    CHECK(d.error < 0.005 * d.mean);
    CHECK(s.error < 0.005 * s.mean);
    CHECK(estimate(picked).mean == estimate(both).mean);  // the beauty does not depend on it
    CHECK(deviation(d, estimate(picked, 1)) < 4.5);
    // A conditional expectation never has more variance; 3 % allows for the noise of the variance estimates.
    CHECK(d.error <= 1.03 * estimate(picked, 1).error);
    CHECK(s.error <= 1.03 * estimate(picked, 2).error);
}

TEST_CASE("Russian roulette changes cost, not the mean", "[render]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    const auto with = render_of(scene, settings);
    settings.samples.seed = 5;
    settings.paths.integrator = path_with(flag_parameter("roulette", false));
    settings.paths.max_depth = 6;
    const auto without = render_of(scene, settings);
    INFO(estimate(with).mean << " " << estimate(without).mean);
    CHECK(deviation(estimate(with), estimate(without)) < 4.5);
    CHECK(estimate(with).error < 0.02 * estimate(with).mean);
    CHECK(with.statistics.scattering_rays < without.statistics.scattering_rays);
}

TEST_CASE("light sampling, scattering and both together agree for every path string", "[render]") {
    // Rough surfaces and a large light, so that every strategy converges; light sampling alone cannot find specular
    // chains.
    const auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 3
LookAt 0 1 3.9  0 1 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 1 1 0 1 1 0 -1 -1 0 -1]
Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.4
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 -1 1 0 -1 1 2 -1 -1 2 -1]
Material "coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "float roughness" 0.5
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 0 -1 1 0 1 1 2 1 1 2 -1]
AreaLightSource "diffuse" "rgb L" [2 2 2]
AttributeBegin Translate -0.6 0.5 0 Shape "sphere" "float radius" 0.3 AttributeEnd
AttributeBegin Translate 0.5 0.5 0 Shape "cylinder" "float radius" 0.2 "float zmin" -0.2 "float zmax" 0.2 AttributeEnd
Shape "bilinearmesh" "point3 P" [0.6 1.9 -0.6 -0.6 1.9 -0.6 0.6 1.9 0.6 -0.6 1.9 0.6]
LightSource "infinite" "rgb L" [0.5 0.5 0.5]
)");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 128;
    settings.paths.max_depth = 3;
    settings.channels.list = {lpe_channel("direct diffuse", "C<RD>[<L.>O]"),
                              lpe_channel("direct specular", "C<RS>[<L.>O]"), lpe_channel("sky", "C.*B"),
                              lpe_channel("rest", "C[DS]{2,}L")};
    std::vector<transport::RenderOutput> outputs;
    for (const char* strategy : {"mis", "light", "scattering"}) {
        settings.paths.integrator = path_with(text_parameter("strategy", strategy));
        ++settings.samples.seed;
        outputs.push_back(render_of(scene, settings));
    }
    for (display::ChannelId id = 0; id <= 4; ++id)
        for (std::size_t other = 1; other < 3; ++other) {
            const Estimate a = estimate(outputs[0], id), b = estimate(outputs[other], id);
            INFO("channel " << id << " strategy " << other << ": " << a.mean << " +- " << a.error << ", " << b.mean
                            << " +- " << b.error);
            CHECK(deviation(a, b) < 4.5);  // 10 comparisons: a false alarm once in 15,000 seeds
            CHECK(b.error < 0.05 * b.mean);
        }
}

TEST_CASE("splits sum and means agree with every strategy where one strategy is inefficient", "[render][law1]") {
    // Veach's plates: small lights in rough plates favour light samples, large ones in smooth plates scattering.
    const auto scene = scene_of(film + R"(
LookAt 0 2 6  0 0.6 0  0 1 0
Camera "perspective" "float fov" 32
WorldBegin
Material "conductor" "rgb reflectance" [0.9 0.9 0.9] "float roughness" 0.08
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0.7 -0.5 2 0.7 -0.5 2 1.1 -1.4 -2 1.1 -1.4]
Material "conductor" "rgb reflectance" [0.9 0.9 0.9] "float roughness" 0.3
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 1 2 0 1 2 0.3 0 -2 0.3 0]
Material "diffuse" "rgb reflectance" [0.4 0.4 0.4]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 -0.2 4 4 -0.2 4 4 -0.2 -4 -4 -0.2 -4]
AttributeBegin AreaLightSource "diffuse" "rgb L" [4 4 4] Translate 1 2.5 -1.5 Shape "sphere" "float radius" 0.5 AttributeEnd
AttributeBegin AreaLightSource "diffuse" "rgb L" [60 60 60] Translate -1 2.5 -1.5 Shape "sphere" "float radius" 0.12 AttributeEnd
LightSource "point" "rgb I" [2 2 2] "point3 from" [0 3 2]
)");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 128;
    settings.paths.max_depth = 2;
    settings.channels.list = {lpe_channel("plates", "C<RS>[<L.>O]"), lpe_channel("floor", "C<RD>.*[<L.>O]"),
                              lpe_channel("rest", "")};
    settings.channels.list[2].rest_of = {0, 1};
    std::vector<transport::RenderOutput> outputs;
    for (const char* strategy : {"mis", "light", "scattering"}) {
        CAPTURE(strategy);
        settings.paths.integrator = path_with(text_parameter("strategy", strategy));
        ++settings.samples.seed;
        outputs.push_back(render_of(scene, settings));
        const display::FrameBuffer& buffer = outputs.back().frame_buffer;
        const std::vector<double> whole = buffer.resolve(0), a = buffer.resolve(1), b = buffer.resolve(2),
                                  c = buffer.resolve(3);
        for (std::size_t i = 0; i < whole.size(); ++i)
            CHECK(std::abs(a[i] + b[i] + c[i] - whole[i]) <= 1e-12 * (a[i] + b[i] + c[i] + whole[i]));
    }
    for (display::ChannelId id = 0; id <= 2; ++id)
        for (std::size_t other = 1; other < 3; ++other) {
            const Estimate a = estimate(outputs[0], id), b = estimate(outputs[other], id);
            INFO("channel " << id << " strategy " << other << ": " << a.mean << " +- " << a.error << ", " << b.mean
                            << " +- " << b.error);
            CHECK(deviation(a, b) < 4.5);
            CHECK(b.error < 0.1 * b.mean);
        }
}

TEST_CASE("lights chosen by power or uniformly have equal means and different noise", "[render]") {
    // One lamp with 400 times the power of each of eight others, all equally far from the floor. Eight in nine uniform
    // choices go to the weak lights, which contribute a fiftieth of the light.
    std::string text = film + R"(
Integrator "path" "integer maxdepth" 2
LookAt 0 3 0.01  0 0 0  0 0 -1
Camera "perspective" "float fov" 40
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 4 4 0 4 4 0 -4 -4 0 -4]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 -2 4 0 -2 4 4 -2 -4 4 -2]
)";
    for (int i = 0; i < 9; ++i)
        text += "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [" +
                std::string(i == 4 ? "40 40 40" : "0.1 0.1 0.1") + "] Translate " + std::to_string(0.4 * (i - 4)) +
                " 4 0 Shape \"sphere\" \"float radius\" 0.15 AttributeEnd\n";
    const auto scene = scene_of(text);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    const auto with = [&](const std::string& strategy, const std::string& selection) {
        settings.paths.integrator = path_with(text_parameter("strategy", strategy));
        settings.paths.integrator->parameters.parameters.push_back(text_parameter("lightsampler", selection));
        ++settings.samples.seed;
        return estimate(render_of(scene, settings));
    };
    for (const char* strategy : {"mis", "light"}) {
        const Estimate power = with(strategy, "power"), even = with(strategy, "uniform");
        INFO(strategy << ": power " << power.mean << " +- " << power.error << ", uniform " << even.mean << " +- "
                      << even.error);
        CHECK(deviation(power, even) < 4.5);
        CHECK(even.error < 0.05 * even.mean);
        // A ninth of uniform choices go to the lamp that matters, and nine tenths of choices by power: 2.8 times the
        // standard deviation from that alone.
        CHECK(even.error > 1.5 * power.error);
    }
    settings.paths.integrator = path_with(text_parameter("lightsampler", "powr"));
    const auto refused = transport::render(scene, settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().to_string().find("expected power, uniform, bvh or exhaustive") != std::string::npos);
    CHECK(refused.error().hint.find("power") != std::string::npos);
}

TEST_CASE("a render that is stopped returns its partial image, marked incomplete", "[render]") {
    std::atomic<bool> stop{true};
    auto output = transport::render(scene_of(room), {}, {}, &stop);
    REQUIRE(output.ok());
    CHECK_FALSE(output->samples.complete);
    CHECK(output->statistics.camera_samples == 0);
    std::uint64_t total = 0, done = 0;
    auto whole = transport::render(scene_of(room), {}, [&](const transport::RenderProgress& p) {
        total = p.samples_total;
        done = p.samples_done;
    });
    REQUIRE(whole.ok());
    CHECK(whole->samples.complete);
    CHECK(total == 24 * 24 * 64);
    CHECK(done == total);
}

TEST_CASE("settings replace the scene's, and unknown names are warnings or errors", "[render]") {
    transport::RenderSettings settings;
    settings.film.resolution = {{8, 6}};
    settings.samples.per_pixel = 3;
    transport::SceneEntity entity;
    entity.type = "sppm";
    settings.paths.integrator = entity;
    auto output = render_of(scene_of(room), settings);
    CHECK(output.view.width == 8);
    CHECK(output.view.height == 6);
    CHECK(output.used.integrator == "bdpt");
    CHECK(output.samples.per_pixel == 3);
    CHECK_FALSE(output.warnings.empty());
    settings.paths.integrator->type = "paht";
    auto unknown = transport::render(scene_of(room), settings);
    REQUIRE_FALSE(unknown.ok());
    CHECK(unknown.error().hint.find("path") != std::string::npos);
    settings.paths.integrator.reset();
    const auto refusal = [](const std::string& text, const transport::RenderSettings& wrong) {
        const auto output = transport::render(scene_of(text), wrong);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.channels.list = {lpe_channel("a", "C<RD>L"), lpe_channel("a", "C<RS>L")};
    CHECK(refusal(room, settings).find("the channel name 'a' is used twice") != std::string::npos);
    settings.channels.list.clear();
    settings.channels.beauty = false;
    CHECK(refusal(room, settings).find("nothing to render: no beauty and no channel") != std::string::npos);
    const std::string camera = refusal("Camera \"fisheye\"\nWorldBegin\n", {});
    CHECK(camera.find("test.pbrt:1:") != std::string::npos);
    CHECK(camera.find("fisheye") != std::string::npos);
}

TEST_CASE("a scene's alphabet names its labels, groups, lobes and terminals", "[render]") {
    using raylex::lpe::EventType;
    using raylex::lpe::Scatter;
    transport::SceneDescription scene = scene_of(room);
    scene.shapes[0].label = "floor";
    REQUIRE(scene.area_lights.size() == 1);
    scene.area_lights[0].group = "ceiling";
    const auto alphabet = transport::scene_alphabet(scene);
    REQUIRE(alphabet.ok());
    CHECK(alphabet->has_lights);
    CHECK(alphabet->has_background);
    CHECK_FALSE(alphabet->has_straight);
    const auto named = [](const std::vector<std::string>& names, const std::string& name) {
        return std::count(names.begin(), names.end(), name) == 1;
    };
    CHECK(named(alphabet->object_labels, "floor"));
    CHECK_FALSE(named(alphabet->object_labels, "ceiling"));
    CHECK(named(alphabet->light_groups, "ceiling"));
    CHECK_FALSE(named(alphabet->light_groups, "floor"));
    const auto terminals = [&](EventType type, const std::string& group) {
        return std::count_if(alphabet->terminals.begin(), alphabet->terminals.end(), [&](const raylex::lpe::Event& e) {
            return e.type == type && e.labels == std::vector<std::string>{group};
        });
    };
    CHECK(alphabet->terminals.size() == 3);
    CHECK(terminals(EventType::light, "ceiling") == 1);
    CHECK(terminals(EventType::light, "") == 1);  // the spot light
    CHECK(terminals(EventType::background, "") == 1);
    const auto scatters = [&](EventType type, Scatter scatter, const std::string& object, const std::string& lobe) {
        return std::count_if(
            alphabet->scattering.begin(), alphabet->scattering.end(), [&](const raylex::lpe::Event& e) {
                return e.type == type && e.scatter == scatter && e.labels == std::vector<std::string>{object, lobe};
            });
    };
    // The floor has the walls' material and its own label; a conductor, smooth glass, a coat over a base.
    CHECK(scatters(EventType::reflection, Scatter::diffuse, "floor", "diffuse") == 1);
    CHECK(scatters(EventType::reflection, Scatter::diffuse, "", "diffuse") == 1);
    CHECK(scatters(EventType::reflection, Scatter::glossy, "", "conductor") == 1);
    CHECK(scatters(EventType::reflection, Scatter::singular, "", "glass") == 1);
    CHECK(scatters(EventType::transmission, Scatter::singular, "", "glass") == 1);
    CHECK(scatters(EventType::reflection, Scatter::glossy, "", "coat") == 1);
    CHECK(alphabet->scattering.size() == 6);
}
