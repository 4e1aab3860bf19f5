// Explains why a path does not match: how far it agrees with the expression, and which event the expression expects
// next.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lpe/event.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// A piece of the expression that could have read the next event.
struct WantedPiece {
    std::size_t begin = 0, end = 0;  ///< its bytes in WhyNot::expression
};

struct WhyNot {
    bool matches = false;
    /// Length in events of the longest prefix with which some matching path begins. The path fails at the next event,
    /// or at its end.
    std::size_t live_events = 0;
    bool any_path = true;   ///< false: the expression matches no path
    bool complete = false;  ///< the prefix itself matches: the path has too many events
    std::string wanted;     ///< the expected event: "one specular scattering or a light of group 'key'"; empty when no
                            ///< event can follow
    std::vector<WantedPiece> pieces;  ///< in text order; empty where '&', '-' or '!' make single pieces meaningless
    std::string hint;                 ///< "its label 'flor' is not 'floor'; did you mean 'floor'?"
    std::string expression;           ///< names are replaced by their definitions
};

/// Compares one path with one channel. Missing labels are empty in `renderman` and absent in `osl`, as in match().
/// Errors: the expression does not parse or is too large.
Result<WhyNot> why_not(const ChannelSource& channel, std::span<const Event> events);

}  // namespace raylex::lpe
