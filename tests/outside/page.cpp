// Runs the examples of experiments/docs/plugins.md, which CMake puts into page_code.h, and checks what they come to.
#include <array>
#include <cmath>
#include <cstdio>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "geoaovs/geoaovs.h"

namespace {

using namespace raylex;

#include "page_code.h"

int failures = 0;

void check(bool holds, const char* what) {
    std::printf("%s the page's example of %s\n", holds ? "holds:" : "FAILS:", what);
    if (!holds) ++failures;
}

std::vector<display::ChannelDefinition> channels() {
    return {{.name = "beauty", .style = display::ChannelStyle::expression, .expression = "C.*"},
            {.name = "heat", .type = display::ChannelType::real},
            {.name = "more", .type = display::ChannelType::real},
            *geoaovs::channel_definition("Nn"),
            {.name = "direct", .style = display::ChannelStyle::expression, .expression = "C<RD>L"}};
}

}  // namespace

int main() {
    const auto list = channels();
    display::SampleTable table(list, 4);
    display::DisplayServices services(table);
    const auto begin = [&] { table.begin(std::array<display::CameraRow, 4>{}); };
    begin();
    const display::ChannelId heat = channel_of(services, "heat"), more = channel_of(services, "more");
    check(heat == 1 && more == 2 && channel_of(services, "nothing") == display::invalid_channel, "GetDisplayChannels");

    send_values(services, 1, heat, more);
    check(table.values(heat)[1] == 3.5 && table.values(more)[1] == 1, "Splat, SplatMulti and Write");

    display::FrameBuffer buffer({1, 1}, list);
    table.begin(std::array<display::CameraRow, 1>{});
    two_sheets_of_glass(services, 0, heat);
    buffer.accumulate(table);
    check(buffer.resolve_alpha()[0] == 0.75 && buffer.resolve(heat)[0] == 2.25, "WriteDistance and AddSample");

    begin();
    warm_up(services, 0, heat);
    check(table.discarded(), "DiscardIteration");

    const auto setup = display::LpeSetup::build(list, 0);
    display::LpeServices lpe(*setup, table, 0);
    begin();
    direct_light(lpe, 2, setup->classify({lpe::EventType::reflection, lpe::Scatter::diffuse, 0, {"", ""}}),
                 setup->classify({lpe::EventType::light, lpe::Scatter::none, 0, {""}}));
    check(table.values(0)[7] == 2 && table.values(4)[7] == 2, "the LPE services");

    const geoaovs::GeometricAovs aovs(list);
    facing_normals(aovs, 3, services);
    check(table.values(3)[11] == -1, "geometric AOVs");

    double_light(table, 0);
    check(table.values(0)[7] == 4, "sample filters");
    return failures == 0 ? 0 : 1;
}
