// Words of subpaths: how trackers are moved along scatterings, and along a light subpath as the camera would have met it.
#pragma once

#include <array>
#include <span>

#include "transport/paths/event_table.h"

namespace raylex::transport {

/// A scattering at an object of this label, each lobe with its share (Law 5).
inline void move_by_lobes(display::Tracker& tracker, display::LpeServices& lpe, const EventTable& events,
                          std::int32_t label, const LobeList& lobes) {
    if (!events.any()) return;
    std::array<display::LobePart, max_lobes> parts;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lobes.count); ++i)
        parts[i] = {events.scatter(label, lobes.entry[i].lobe), lobes.entry[i].value};
    lpe.move(tracker, {parts.data(), static_cast<std::size_t>(lobes.count)});
}

/// One event of a light subpath. Straight events have no lobes.
struct WordEvent {
    std::int32_t label = 0;
    bool straight = false;
    LobeList lobes;
};

/// From behind a join to the light: `word` from the light, `light` its terminal.
inline void move_to_light(display::Tracker& tracker, display::LpeServices& lpe, const EventTable& events,
                          std::span<const WordEvent> word, std::uint32_t light) {
    for (auto event = word.rbegin(); event != word.rend() && lpe.channels_follow(tracker); ++event) {
        if (event->straight) lpe.move(tracker, events.straight(event->label));
        else move_by_lobes(tracker, lpe, events, event->label, event->lobes);
    }
    lpe.move(tracker, events.terminal(light));
}

}  // namespace raylex::transport
