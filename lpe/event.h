// The alphabet. A light path is a string of events, the camera first and a terminal (light, background or emission)
// last.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raylex::lpe {

/// The type of an event: C R T V L B O, or a user event (U1 to U12), which no wildcard matches.
enum class EventType : std::uint8_t { camera, reflection, transmission, volume, light, background, emission, user };

/// The scattering: D G S s, or none (cameras, terminals, phase scattering).
enum class Scatter : std::uint8_t { none, diffuse, glossy, singular, straight };

/// One event of a path.
///
/// Scene events always have their label slots, with the empty string for "no label": (object, lobe) for scattering,
/// (light group) for terminals. An event read from text can have fewer. In the `osl` dialect a trailing empty label
/// counts as absent; in `renderman` an absent label counts as empty.
struct Event {
    EventType type = EventType::camera;
    Scatter scatter = Scatter::none;
    std::uint8_t lobe_number = 0;  ///< D1..D4, S1..S8 for scattering, 1..12 for user events; 0 = unnumbered
    std::vector<std::string> labels;

    bool operator==(const Event&) const = default;
};

/// Blanks separate the events of a path in text, and the names of an expression.
[[nodiscard]] constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// The language of an expression; lpe/README.md has both grammars.
enum class Dialect : std::uint8_t { renderman, osl };

}  // namespace raylex::lpe
