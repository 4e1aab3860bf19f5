// Events as text, and matching one expression against one path.
//
//     events := event { blank event }        blanks and tabs separate events
//     event  := type ',' scatter { ',' label }
//     type   := C R T V L B O, or U1..U12
//     scatter:= '-' (none) or D G S s, D and S with an optional lobe number (D1..D4, S1..S8, G1..G8)
//     label  := text without blanks, commas and quotes, or 'text' or "text" (a backslash makes the next byte literal)
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// Parses "C,- R,D,floor L,-,key". An empty text is the empty path. Errors contain line 1 and the column in bytes.
Result<std::vector<Event>> parse_events(std::string_view text);

/// Events with their positions in the text (bytes from 0).
struct PlacedEvents {
    std::vector<Event> events;
    std::vector<std::size_t> offsets;
};
Result<PlacedEvents> parse_placed_events(std::string_view text);

/// The text of events; parse_events() reads it back. Trailing empty labels are omitted; labels are quoted if necessary.
std::string to_text(const Event& event);
std::string to_text(std::span<const Event> events);

/// The path in English: "camera, diffuse reflection off 'floor', light 'key'".
std::string to_sentence(std::span<const Event> events);
std::string to_sentence(const Event& event);

/// Returns whether the expression accepts the whole path. Missing labels are empty in `renderman` and absent in `osl`.
/// Errors: the expression does not parse or is too large.
Result<bool> match(std::string_view expression, std::span<const Event> events, Dialect dialect);

}  // namespace raylex::lpe
