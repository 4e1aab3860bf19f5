// The sets of lights to choose from, with more sets than choosers and more groups than bits.
#include "transport/paths/subpaths/live_lights.h"
#include "transport/render_support.h"

using namespace render_test;

namespace {

/// A grey ball under `count` point lights, each a group of its own.
transport::SceneDescription many_groups(std::size_t count) {
    std::string text = film + "Camera \"perspective\"\nWorldBegin\n";
    for (std::size_t k = 0; k < count; ++k)
        text += "LightSource \"point\" \"point3 from\" [" + std::to_string(k) + " 9 0]\n";
    auto scene = scene_of(text + "Material \"diffuse\"\nShape \"sphere\"\n");
    for (std::size_t k = 0; k < count; ++k) scene.lights.at(k).group = "g" + std::to_string(k);
    return scene;
}

}  // namespace

TEST_CASE("the chooser of a state contains every light that can end its path strings", "[lights][pruning][law4]") {
    for (const std::size_t groups : {8, 40, 72}) {
        CAPTURE(groups);
        auto built = transport::BuiltScene::build(many_groups(groups));
        REQUIRE(built.ok());
        const transport::SceneView view = (*built)->view();
        // After k scatterings only light of group k is accepted, so there are as many sets as groups.
        std::vector<display::ChannelDefinition> channels;
        for (std::size_t k = 1; k < groups; ++k)
            channels.push_back(lpe_channel("c" + std::to_string(k),
                                           "C<RD>{" + std::to_string(k) + "}<L.'g" + std::to_string(k) + "'>"));
        auto setup = display::LpeSetup::build(channels, display::invalid_channel);
        REQUIRE(setup.ok());
        const transport::EventTable events(*setup, view, {});
        const transport::LiveLights lights(view, events, transport::LightChoice::mis, false);
        display::SampleTable table(channels, 1);
        const display::CameraRow row[1] = {};
        table.begin(row);
        const display::LpeServices services(*setup, table, 1);
        display::Tracker tracker = services.begin(0);
        const auto diffuse = events.scatterings(0, 0);
        REQUIRE(diffuse.size() == 1);
        std::size_t alone = 0;
        for (std::size_t k = 1; k < groups; ++k) {
            services.move(tracker, diffuse[0]);
            const display::Liveness::LiveSet live = events.liveness().of(tracker);
            const transport::LightChooser& chooser = lights[lights.of(live)];
            const auto light = static_cast<std::uint32_t>(k);
            CHECK((live.terminals & events.liveness().bit_of(events.terminal(light))) != 0);
            CHECK(chooser.probability(Vec3(), light) > 0);
            alone += chooser.probability(Vec3(), light) == 1;
        }
        // The number of choosers is limited: of the 32, one is for all lights, one for none, one for all lights that
        // end any path string, and one may be for groups beyond the 63rd bit.
        CHECK(alone >= std::min<std::size_t>(groups - 1, 28));
        CHECK(lights[lights.of({})].probability(Vec3(), 0) > 0);  // nothing is known, so any light is possible
    }
}
