// Channels that are several splits of one beauty side by side (by lobe, and by light group), sorted into them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

struct Sorting {
    std::vector<std::vector<std::size_t>> partitions;  ///< of the beauty, each proved; no channel is in two
    std::vector<std::size_t> left;                     ///< channels in none of them
    bool gave_up = false;  ///< more was tried than is worth it: channels that are left may still be in one
};

/// Sorts the channels into partitions of `beauty` (of W when absent): from the first channel that is in none yet, the
/// shortest path missed so far is given to one channel after the other that counts it. Errors as check_partition's.
Result<Sorting> sort_into_partitions(std::span<const ChannelSource> channels,
                                     const std::optional<ChannelSource>& beauty = std::nullopt,
                                     const Words& words = {});

}  // namespace raylex::lpe
