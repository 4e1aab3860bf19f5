// Why a path does not match: how far it went well, and what the expression wanted next.
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
    /// Events of the longest live prefix: some path that begins with them matches. The event after them, or the end of
    /// the path, is where it failed.
    std::size_t live_events = 0;
    bool any_path = true;   ///< false: the expression matches nothing at all
    bool complete = false;  ///< the live prefix itself matches: the path goes on too long
    std::string wanted;     ///< "one specular scattering or a light of group 'key'"; empty when nothing could follow
    std::vector<WantedPiece> pieces;  ///< in the order of the text; empty where '&', '-' or '!' leave no single piece
    std::string hint;                 ///< "its label 'flor' is not 'floor'; did you mean 'floor'?"
    std::string expression;           ///< with names replaced by what they stand for
};

/// Labels that an event lacks are empty to `renderman` and absent to `osl`, as for match(). Errors: the expression does
/// not parse or is too large.
Result<WhyNot> why_not(const ChannelSource& channel, std::span<const Event> events);

}  // namespace raylex::lpe
