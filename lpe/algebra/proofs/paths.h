// Combines the languages of channels and lists, samples and counts the resulting paths: for example the paths of one
// channel that another does not accept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// The operation on the channels; their dialects can differ.
enum class Operation : std::uint8_t {
    words,         ///< paths of the one channel
    complement,    ///< paths of W that the one channel does not accept
    intersection,  ///< paths that all channels accept
    united,        ///< paths that at least one channel accepts
    difference     ///< paths that the first channel accepts and no other
};

struct PathSetOptions {
    std::size_t samples = 5;
    std::size_t longest_counted = 8;  ///< events
};

/// Facts about a set of paths, restricted to W.
struct PathSet {
    std::vector<Witness> samples;  ///< shortest first; empty when the set is empty
    /// Numbers of paths with 0, 1, ... events, each at most 1e18. Events of different type or scattering count as
    /// different. Lobe numbers and labels count as different only if an expression distinguishes them.
    std::vector<std::uint64_t> counts;
    std::optional<std::size_t> longest;  ///< length in events of the longest path, if the set is finite
    std::size_t states = 0;              ///< states of the minimal automaton, without the dead state
    std::vector<std::string> warnings;
    [[nodiscard]] bool empty() const { return samples.empty(); }
};

/// Evaluates the operation. Errors: an expression does not parse or is too large; no channel, or more than one for
/// `words` and `complement`.
Result<PathSet> look_at_paths(Operation operation, std::span<const ChannelSource> channels,
                              const PathStrings& words = {}, const PathSetOptions& options = {});

}  // namespace raylex::lpe
