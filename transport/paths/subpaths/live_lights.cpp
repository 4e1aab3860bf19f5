#include "transport/paths/subpaths/live_lights.h"

#include <algorithm>

namespace raylex::transport {

namespace {

/// Sets of terminals that may lie ahead of a path in one state, or in several: a tracker holds several states, for
/// branches and for bit-parallel channels. Returns the unions of these sets, up to `most`, and a set that contains them
/// all.
std::vector<std::uint64_t> sets_of_terminals(const display::Liveness& liveness, std::size_t most) {
    std::vector<std::uint64_t> sets;
    const auto add = [&](std::uint64_t set) {
        if (std::find(sets.begin(), sets.end(), set) == sets.end()) sets.push_back(set);
    };
    if (liveness.is_known()) add(liveness.live_terminals());
    for (const std::uint64_t set : liveness.sets_of_terminals()) add(set);
    for (std::size_t i = 1; i < sets.size() && sets.size() < most; ++i)
        for (std::size_t j = 0; j < i && sets.size() < most; ++j) add(sets[i] | sets[j]);
    return sets;
}

}  // namespace

LiveLights::LiveLights(const SceneView& scene, const EventTable& events, LightChoice choice, bool by_receiver)
    : choice_(choice), by_receiver_(by_receiver) {
    const std::span<const Light> lights = scene.lights->lights();
    const auto make = [&](std::span<const std::uint8_t> wanted) {
        return by_receiver ? LightChooser::by_receiver(lights, *scene.geometry, choice, wanted)
                           : LightChooser(lights, choice, wanted);
    };
    choosers_[all] = make({});
    const std::size_t count = lights.size();
    std::vector<std::uint8_t> wanted(count);
    for (const std::uint64_t terminals : sets_of_terminals(events.liveness(), 2 * most_choosers)) {
        if (choosers_.size() == most_choosers) break;
        for (std::uint32_t light = 0; light < count; ++light)
            wanted[light] = (terminals & events.liveness().bit_of(events.terminal(light))) != 0;
        const auto lights_of_set = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1));
        if (lights_of_set == count) continue;  // the same as `all`
        LightChooser chooser = make(wanted);
        if (chooser.empty()) {
            sets_.push_back({terminals, lights_of_set, none});
            continue;
        }
        sets_.push_back({terminals, lights_of_set, static_cast<std::uint8_t>(choosers_.size())});
        choosers_.push_back(std::move(chooser));
    }
    std::stable_sort(sets_.begin(), sets_.end(), [](const Set& a, const Set& b) { return a.lights < b.lights; });
}

LiveLights LiveLights::alike_everywhere(const SceneView& scene, const EventTable& events,
                                        const LightLanguage* language) {
    const std::span<const Light> lights = scene.lights->lights();
    LiveLights live;
    LightChooser& chooser = live.choosers_[all];
    chooser =
        choose_live_lights(scene, events, language, LightChoice::mis, &display::SuffixLiveness::LiveSet::connects);
    std::uint64_t sampled = 0;
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        if (chooser.probability(Vec3(), light) > 0) sampled |= events.liveness().bit_of(events.terminal(light));
    live.sets_.push_back({~sampled, 0, none});
    live.none_is_live_ = chooser.empty() && !LightChooser(lights, LightChoice::mis).empty();
    return live;
}

LightChooser choose_live_lights(const SceneView& scene, const EventTable& events, const LightLanguage* language,
                                LightChoice choice, bool display::SuffixLiveness::LiveSet::*wanted) {
    const std::span<const Light> lights = scene.lights->lights();
    std::vector<std::uint8_t> live(lights.size(), 1);
    for (std::uint32_t light = 0; language != nullptr && light < lights.size(); ++light)
        live[light] = language->live_set_of(events.terminal(light)).*wanted;
    return {lights, choice, live};
}

}  // namespace raylex::transport
