// Bidirectional path tracing against the path tracer, word by word.
#include "transport/replicates.h"

using namespace render_test;

TEST_CASE("bidirectional path tracing finds the path tracer's image, word by word", "[bdpt][render][statistical]") {
    transport::RenderSettings settings;
    settings.max_depth = 4;
    settings.samples_per_pixel = 256;
    settings.resolution = {{18, 18}};
    compare_with_path(room, settings, integrator_named("bdpt"), 12, 128,
                      {"C<.[DG]>L", "C<.[DG]>B", "CL", "C<RD><.S>+L", "C<.S>+<RD>L", "C<RD><RD>+[LB]", "C<RG>.*L",
                       "C<.S>.*[LB]", "C<RD><.G>.*[LB]", "C.*[LB]"});
}

TEST_CASE("bidirectional path tracing through lenses and cutouts, with shading normals and every kind of light",
          "[bdpt][render][statistical]") {
    transport::RenderSettings settings;
    settings.max_depth = 3;
    settings.samples_per_pixel = 256;
    // What only light subpaths find (a mirror's caustic of the spot light) has no counterpart and is left out.
    compare_with_path(many_lights(), settings, integrator_named("bdpt"), 12, 256,
                      {"C<RD>[LB]", "C<Ts><RD>[LB]", "C<RD><RS>+B", "C<RS>.*[LB]", "C<RG>[LB]", "C<RD><.G>+[LB]",
                       "C<RD><RD>[LB]", "C<Ts>*[LB]"});
}

TEST_CASE("what bidirectional path tracing cannot do yet is refused by name", "[bdpt][render][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples_per_pixel = 1;
    settings.integrator = integrator_named("bdpt");
    CHECK(render_of(scene, settings).warnings.empty());
    const auto error = [&] {
        const auto output = transport::render(scene, settings);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.adaptive.emplace();
    CHECK(error().find("integrator 'bdpt'") != std::string::npos);
    settings.adaptive.reset();
    settings.channels = {lpe_channel("u", "unoccluded;C.*L")};
    settings.channels[0].statistics = false;
    CHECK(error().find("samples no lights") != std::string::npos);
}
