// The whole picture of channels that are no partition: every pair that shares paths, every kind of path that none
// counts, every channel that goes outside. check.h gives the verdict, and the one path that decides it.
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

/// Missed paths that begin alike: seen directly, or with the same kind of scattering.
struct Hole {
    std::string kind;             ///< "first a diffuse reflection", "seen directly"
    Witness witness;              ///< the shortest
    std::vector<Witness> others;  ///< the shortest that end at another kind of terminal (L, B, O)
};

/// A path that a channel counts although what is split does not contain it, the shortest.
struct OutsidePath {
    std::size_t channel = 0;
    Witness witness;
};

struct Overview {
    std::vector<SharedPath> overlaps;  ///< by first, then second
    std::vector<Hole> holes;
    std::vector<OutsidePath> outside;
    std::vector<std::size_t> empty;  ///< channels that count no path
    std::size_t pairs_left = 0;      ///< pairs that were not compared, for there are too many
    std::string holes_unknown;       ///< why holes were not looked for, where the channels together are too large
};

/// Relative to W; `beauty` is what is split, all of W when absent. Errors: a channel that does not parse, carries
/// prefixes, or is too large by itself.
Result<Overview> look_over(std::span<const ChannelSource> channels,
                           const std::optional<ChannelSource>& beauty = std::nullopt, const Words& words = {});

}  // namespace raylex::lpe
