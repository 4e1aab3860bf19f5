#include "transport/paths/subpaths/live_lights.h"

#include <algorithm>

namespace raylex::transport {

LiveLights::LiveLights(const SceneView& scene, const EventTable& events, LightChoice choice, bool by_receiver) {
    const std::span<const Light> lights = scene.lights->lights();
    const auto make = [&](std::span<const std::uint8_t> wanted) {
        return by_receiver ? LightChooser::by_receiver(lights, *scene.geometry, choice, wanted)
                           : LightChooser(lights, choice, wanted);
    };
    choosers_[all] = make({});
    const std::size_t count = lights.size();
    std::vector<std::uint8_t> wanted(count);
    for (const std::uint64_t terminals : events.foresight().sets_of_terminals()) {
        for (std::uint32_t light = 0; light < count; ++light)
            wanted[light] = (terminals & events.foresight().bit_of(events.terminal(light))) != 0;
        const bool every = std::find(wanted.begin(), wanted.end(), 0) == wanted.end();
        if (every || choosers_.size() == most_choosers) continue;  // `all` will do
        LightChooser chooser = make(wanted);
        if (chooser.empty()) {
            sets_.push_back({terminals, none});
            continue;
        }
        sets_.push_back({terminals, static_cast<std::uint8_t>(choosers_.size())});
        choosers_.push_back(std::move(chooser));
    }
}

LightChooser choose_live_lights(const SceneView& scene, const EventTable& events, const LightLanguage* language,
                                LightChoice choice, bool display::LightForesight::Ahead::*wanted) {
    const std::span<const Light> lights = scene.lights->lights();
    std::vector<std::uint8_t> live(lights.size(), 1);
    for (std::uint32_t light = 0; language != nullptr && light < lights.size(); ++light)
        live[light] = language->foresight().of(events.terminal(light)).*wanted;
    return {lights, choice, live};
}

}  // namespace raylex::transport
