// Languages made of languages, and a look into them: which paths are in one channel and not in another, how many,
// which.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

/// What is made of the channels; dialects may differ.
enum class Operation : std::uint8_t {
    words,         ///< the one channel itself
    complement,    ///< W but the one channel
    intersection,  ///< what all accept
    united,        ///< what any accepts
    difference     ///< what the first accepts and no other
};

struct PathSetOptions {
    std::size_t samples = 5;
    std::size_t longest_counted = 8;  ///< events
};

/// What is known of a set of paths, cut to W.
struct PathSet {
    std::vector<Witness> samples;  ///< the shortest first; none when there is no path
    /// Paths of 0, 1, ... events, at most 1e18. Events that differ in type or scattering count as different; lobe
    /// numbers and labels only as far as the expressions tell them apart.
    std::vector<std::uint64_t> counts;
    std::optional<std::size_t> longest;  ///< events of the longest path, where there is a longest
    std::size_t states = 0;              ///< of the minimal automaton, the dead one left out
    std::vector<std::string> warnings;
    [[nodiscard]] bool empty() const { return samples.empty(); }
};

/// Errors: an expression that does not parse or is too large; no channel, or more than one for `words` and
/// `complement`.
Result<PathSet> look_at_paths(Operation operation, std::span<const ChannelSource> channels, const Words& words = {},
                              const PathSetOptions& options = {});

}  // namespace raylex::lpe
