// Threads that add to the same tile.
#include "transport/render_support.h"

using namespace render_test;

TEST_CASE("an image of one tile has the same bits if several threads add its blocks at once", "[render][law3]") {
    // 1024 blocks of one tile of 4 x 4 pixels: four threads nearly always add to the frame buffer at once.
    auto scene = scene_of(room);
    auto built = transport::BuiltScene::build(scene);
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.film.resolution = {{4, 4}};
    settings.samples.per_pixel = 16384;
    settings.paths.max_depth = 1;
    settings.channels.list = {lpe_channel("direct", "C<RD>.*")};
    settings.machine.threads = 1;
    auto one = transport::render(**built, settings);
    REQUIRE(one.ok());
    settings.machine.threads = 4;
    auto four = transport::render(**built, settings);
    REQUIRE(four.ok());
    for (display::ChannelId id = 0; id < 2; ++id)
        CHECK(one->frame_buffer.resolve(id) == four->frame_buffer.resolve(id));
}
