// A renderer's-eye view of the two adoptable components: compile channels, follow a path, read the sample table.
#include <cmath>
#include <cstdio>
#include <vector>

#include "display/services/samples/lpe_services.h"

int main() {
    using namespace raylex;
    std::vector<display::ChannelDefinition> channels(3);
    channels[0].name = "beauty";
    channels[1].name = "direct";
    channels[1].style = display::ChannelStyle::expression;
    channels[1].expression = "C<RD>L";
    channels[2].name = "indirect";
    channels[2].style = display::ChannelStyle::expression;
    channels[2].expression = "C<RD>[DS]+L";

    auto setup = display::LpeSetup::build(channels, 0);
    if (!setup) return std::fprintf(stderr, "%s\n", setup.error().to_string().c_str()), 1;
    const lpe::EventClass diffuse =
        setup->classify({lpe::EventType::reflection, lpe::Scatter::diffuse, 0, {"", "diffuse"}});
    const lpe::EventClass light = setup->classify({lpe::EventType::light, lpe::Scatter::none, 0, {""}});

    display::SampleTable table(channels, 16);
    const std::vector<display::CameraRow> rows(1);
    table.begin(rows);
    display::LpeServices services(*setup, table, 0);
    auto tracker = services.begin(0);
    services.move(tracker, diffuse);
    auto lit = tracker;
    services.move(lit, light);
    services.contribute(Rgb(0.25f), display::Technique{1, 2}, lit);
    services.move(tracker, diffuse);
    services.move(tracker, light);
    services.contribute(Rgb(0.5f), display::Technique{}, tracker);

    const double beauty = table.values(0)[0], direct = table.values(1)[0], indirect = table.values(2)[0];
    std::printf("beauty %g = direct %g + indirect %g\n", beauty, direct, indirect);
    return beauty == 0.75 && direct == 0.25 && indirect == 0.5 ? 0 : 1;
}
