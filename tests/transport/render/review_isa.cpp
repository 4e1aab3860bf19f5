#include "transport/render_support.h"

#include "display/services/processor.h"

using namespace render_test;

TEST_CASE("The record names the instruction set that was used, and requesting it gives the same bits", "[law3]") {
    const transport::SceneDescription scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    const transport::RenderOutput chosen = render_of(scene, settings);
    CHECK(display::supports(chosen.used.isa));
    settings.machine.isa = chosen.used.isa;
    const transport::RenderOutput forced = render_of(scene, settings);
    CHECK(forced.used.isa == chosen.used.isa);
    CHECK(forced.frame_buffer.resolve(forced.beauty) == chosen.frame_buffer.resolve(chosen.beauty));
}
