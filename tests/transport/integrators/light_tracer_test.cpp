// The light tracer against the path tracer, word by word, and the laws.
#include "transport/interrupted_render.h"
#include "transport/materials_support.h"
#include "transport/replicates.h"

using namespace render_test;

TEST_CASE("the light tracer finds the path tracer's image, word by word", "[lighttracer][render][statistical][gate]") {
    // Rough and smooth conductors, glass, a coat, an area light, a sky and a spot light.
    transport::RenderSettings settings;
    settings.paths.max_depth = 4;
    settings.samples.per_pixel = 256;
    settings.film.resolution = {{18, 18}};
    compare_with_path(room, settings, integrator_named("lighttracer"), 12, 256,
                      {"C<.[DG]>L", "C<.[DG]>B", "CL", "C<RD><.S>+L", "C<RD><RD>+[LB]", "C<RG>.*L", "C<RD><.G>.*[LB]"});
}

TEST_CASE("the light tracer through lenses and cutouts, with shading normals and every kind of light",
          "[lighttracer][render][statistical][gate]") {
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.samples.per_pixel = 256;
    compare_with_path(
        many_lights(), settings, integrator_named("lighttracer"), 12, 384,
        {"C<RD>[LB]", "C<Ts><RD>[LB]", "C<RD><RS>+B", "C<RG>[LB]", "C<RD><.G>+[LB]", "C<RD><RD>[LB]", "C<Ts>*[LB]"});
}

TEST_CASE("light that begins in glass leaves it with all its power", "[lighttracer][bdpt][render][statistical][gate]") {
    // A ball of radius 0.2 and radiance 1 in the middle of a glass ball of 1 in the middle of a grey one of 3. All of
    // it meets the glass at angles below 12 degrees and by symmetry spreads evenly: rho r^2 / R^2 (1 - F) as seen on
    // the outer ball, F being the mean reflectance by the midpoint rule. Scaled by 1 / eta^2 as radiance is, it would
    // be 2.25 times darker; where light enters and leaves the glass the two cancel.
    double expected = 0;
    constexpr int steps = 1000;
    for (int i = 0; i < steps; ++i) {
        const double sine_squared = (i + 0.5) / steps;  // of emission, cosine-weighted: uniform in its square
        expected +=
            0.5 * 0.04 / 9 / steps * (1 - raylex::test::fresnel_by_snell(std::sqrt(1 - 0.04 * sine_squared), 1.5, 1));
    }
    const std::string integrator = GENERATE("lighttracer", "bdpt");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.paths.integrator = integrator_named(integrator);
    settings.channels.list = {osl("once", "C<RD><TS>L")};
    auto built = transport::BuiltScene::build(scene_of(film + R"(
Integrator "path" "integer maxdepth" 2
LookAt 0 0 1.5  0 0 3  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [1 1 1]
  Shape "sphere" "float radius" 0.2
AttributeEnd
AttributeBegin
  Material "dielectric" "float eta" 1.5
  Shape "sphere" "float radius" 1
AttributeEnd
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "sphere" "float radius" 3
)"));
    REQUIRE(built.ok());
    settings.channels.beauty = false;
    check_closed_forms(replicates(**built, settings, 1, 16, 1), {{"C<RD><TS>L", expected}}, 2, 0.02);
}

TEST_CASE("methods that splat keep the laws: splits sum, asking changes nothing, threads and interruptions neither",
          "[lighttracer][bdpt][render][law1][law2][law3][gate]") {
    const std::string integrator = GENERATE("lighttracer", "bdpt");
    CAPTURE(integrator);
    const auto scene = scene_of(GENERATE(false, true) ? foggy_room() : room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 20;
    settings.paths.integrator = integrator_named(integrator);
    transport::SceneEntity filter;
    filter.type = "mitchell";
    settings.film.filter = filter;
    for (const bool splat : {false, true}) {
        CAPTURE(splat);
        settings.film.splat = splat;
        settings.channels.list.clear();
        settings.machine.threads = 3;
        const auto alone = render_of(scene, settings);
        settings.channels.list = {osl("direct", "C<RD>L"), osl("caustic", "C<RD><.S>+L"), osl("seen", "C[LB]"),
                                  osl("rest", "")};
        settings.channels.list[3].rest_of = {0, 1, 2};
        const auto three = render_of(scene, settings);
        settings.machine.threads = 1;
        const auto one = render_of(scene, settings);
        const auto side = static_cast<std::uint64_t>(24 + (splat ? 4 : 0));
        CHECK(one.frame_buffer.light_path_count() == side * side * 20);
        for (display::ChannelId id = 0; id < 5; ++id)
            CHECK(one.frame_buffer.resolve(id) == three.frame_buffer.resolve(id));
        CHECK(one.frame_buffer.resolve(0) == alone.frame_buffer.resolve(0));
        CHECK(one.frame_buffer.resolve_alpha() == alone.frame_buffer.resolve_alpha());
        std::array<std::vector<double>, 5> layers;
        for (std::size_t id = 0; id < 5; ++id)
            layers[id] = one.frame_buffer.resolve(static_cast<display::ChannelId>(id));
        std::array<double, 5> light{};
        for (std::size_t i = 0; i < layers[0].size(); ++i) {
            double sum = 0, magnitude = std::abs(layers[0][i]);
            for (std::size_t id = 0; id < 5; ++id) {
                light[id] += std::abs(layers[id][i]);
                if (id == 0) continue;
                sum += layers[id][i];
                magnitude += std::abs(layers[id][i]);
            }
            CHECK(std::abs(sum - layers[0][i]) <= 1e-12 * magnitude);
        }
        for (const double each : light) CHECK(each > 0);

        // Stopped after half the samples, saved, and gone on with.
        const ScratchFile file;
        settings.checkpoint = transport::CheckpointSettings{.file = file.path()};
        settings.machine.threads = 2;
        settings.paths.integrator = counted(integrator);
        std::atomic<bool> stop{false};
        interruption().begin(side * side * 10, &stop);
        const auto first = transport::render(scene, settings, {}, &stop);
        interruption().begin(0, nullptr);
        REQUIRE(first.ok());
        REQUIRE_FALSE(first->samples.complete);
        settings.checkpoint->resume = true;
        const auto resumed = render_of(scene, settings);
        CHECK(resumed.frame_buffer.light_path_count() == one.frame_buffer.light_path_count());
        for (display::ChannelId id = 0; id < 5; ++id)
            CHECK(one.frame_buffer.resolve(id) == resumed.frame_buffer.resolve(id));
        settings.paths.integrator = integrator_named(integrator);
        settings.checkpoint.reset();
    }
}

TEST_CASE("what the light tracer cannot do is refused or said", "[lighttracer][render][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1;
    settings.paths.integrator = integrator_named("lighttracer");
    const auto said = render_of(scene, settings);
    REQUIRE(said.warnings.size() == 1);
    CHECK(said.warnings[0].message.find("first scattering is singular") != std::string::npos);
    settings.channels.list = {lpe_channel("albedo", "CU2L")};
    const auto surfaces = render_of(scene, settings);
    CHECK(std::any_of(surfaces.warnings.begin(), surfaces.warnings.end(), [](const raylex::Error& warning) {
        return warning.message.find("C.+U is missing") != std::string::npos;
    }));
    settings.paths.integrator = integrator_named("path");
    CHECK(surfaces.frame_buffer.resolve(1) == render_of(scene, settings).frame_buffer.resolve(1));
    settings.paths.integrator = integrator_named("lighttracer");
    settings.channels.list.clear();
    const auto error = [&] {
        const auto output = transport::render(scene, settings);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.channels.statistics = {*display::parse_statistic_request("beauty", "mse", {"job.toml", 3, 1})};
    CHECK(error().find("job.toml:3:1") != std::string::npos);
    CHECK(error().find("'lighttracer'") != std::string::npos);
    settings.channels.statistics.clear();
    settings.channels.list = {lpe_channel("a", "CDL")};  // moments that nobody asks a layer of are just not kept
    CHECK(render_of(scene, settings).frame_buffer.resolve_variance_of_mean(1).empty());
    settings.channels.list[0].rule = display::FilterRule::max;
    CHECK(error().find("no rule but the pixel filter") != std::string::npos);
    settings.channels.list.clear();
    settings.stop.adaptive.emplace();
    CHECK(error().find("cannot sample adaptively") != std::string::npos);
    settings.stop.adaptive.reset();
    transport::SceneEntity clamp;
    clamp.type = "clamp";
    settings.channels.sample_filters = {clamp};
    CHECK(error().find("sample filters ('clamp')") != std::string::npos);
    settings.channels.sample_filters.clear();
    settings.channels.list = {osl("u", "unoccluded;C.*L")};
    settings.channels.list[0].dialect = raylex::lpe::Dialect::renderman;
    CHECK(error().find("samples no lights") != std::string::npos);
}
