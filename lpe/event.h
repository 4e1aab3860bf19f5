// The alphabet. A light path is a word of events, camera first, terminal (light, background or emission) last.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raylex::lpe {

/// What happened: C R T V L B O, or a user event (U1..U12), which no wildcard matches.
enum class EventType : std::uint8_t { camera, reflection, transmission, volume, light, background, emission, user };

/// How it scattered: D G S s, or nothing (cameras, terminals, phase scattering).
enum class Scatter : std::uint8_t { none, diffuse, glossy, singular, straight };

/// One event of a path.
///
/// Scene events always carry their label slots, the empty string standing for "no label": (object, lobe) for
/// scattering, (light group) for terminals. An event read from text may carry fewer; to the `osl` dialect a trailing
/// empty label is an absent one, to `renderman` an absent one is an empty one.
struct Event {
    EventType type = EventType::camera;
    Scatter scatter = Scatter::none;
    std::uint8_t lobe_number = 0;  ///< D1..D4, S1..S8 for scattering, 1..12 for user events; 0 = unnumbered
    std::vector<std::string> labels;

    bool operator==(const Event&) const = default;
};

/// The language an expression is written in; see lpe/README.md for both grammars.
enum class Dialect : std::uint8_t { renderman, osl };

}  // namespace raylex::lpe
