// Threads that meet in one tile.
#include "transport/render_support.h"

using namespace render_test;

TEST_CASE("an image of one tile is the same bits when several threads hold its blocks at once", "[render][law3]") {
    // 1024 blocks of one tile of 4 x 4 pixels: with four threads, nearly always in the frame buffer together.
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
