// An overview of channels that are not a partition: every pair that shares paths, every kind of path that no channel
// counts, and every channel that accepts paths outside the beauty. check.h gives the one answer and its counterexample.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"

namespace raylex::lpe {

/// Two channels, first < second, and the shortest path that both count.
struct SharedPath {
    std::size_t first = 0, second = 0;
    Witness witness;
};

/// Missed paths of one kind: seen directly, or with the same kind of first scattering.
struct Hole {
    std::string kind;             ///< "first a diffuse reflection", "seen directly"
    Witness witness;              ///< the shortest missed path
    std::vector<Witness> others;  ///< the shortest missed path for each other kind of terminal (L, B, O)
};

/// The shortest path that a channel counts although the beauty does not contain it.
struct OutsidePath {
    std::size_t channel = 0;
    Witness witness;
};

struct Overview {
    std::vector<SharedPath> overlaps;  ///< sorted by first, then second
    std::vector<Hole> holes;
    std::vector<OutsidePath> outside;
    std::vector<std::size_t> empty;  ///< channels that count no path
    std::size_t pairs_left = 0;      ///< pairs that were not compared because the limit on transitions was reached
    std::string holes_unknown;       ///< the reason why holes were not searched: the channels together are too large
};

/// Compares the channels over W. `beauty` is the expression that they split, all of W when absent. Errors: a channel
/// does not parse, carries prefixes, or is too large by itself.
Result<Overview> look_over(std::span<const ChannelSource> channels,
                           const std::optional<ChannelSource>& beauty = std::nullopt, const PathStrings& words = {});

}  // namespace raylex::lpe
