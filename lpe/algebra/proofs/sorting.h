// Sorts channels that form several splits of one beauty (by lobe, and by light group) into these splits.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct Sorting {
    std::vector<std::vector<std::size_t>> partitions;  ///< proved partitions of the beauty; no channel is in two
    std::vector<std::size_t> left;                     ///< channels in none of the partitions
    bool gave_up = false;  ///< the search stopped at its limit: channels in `left` may still belong to a partition
};

/// Sorts the channels into partitions of `beauty` (of W when absent). The search starts from the first channel that is
/// in no partition yet, and repeatedly adds a channel that counts the shortest path missed so far. Errors: those of
/// check_partition().
Result<Sorting> sort_into_partitions(std::span<const ChannelSource> channels,
                                     const std::optional<ChannelSource>& beauty = std::nullopt,
                                     const PathStrings& words = {});

}  // namespace raylex::lpe
