// Results of several machines or sessions as one directory.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct MergeOutcome {
    std::size_t done = 0, failed = 0, missing = 0;
};

/// Copies the finished and failed cells and the references of all directories, byte by byte, to a new one; the order of
/// the directories does not matter. Errors, before anything is written: directories of different configs or scenes, a
/// cell that two of them have finished, two cells with one seed, no new directory. A cell that failed in one and is
/// done in another is done. Parts of a cell (cell_parts.h) become the cell, bit for bit what one run renders, its times
/// the sums of theirs; Errors: samples that are there twice or not at all, a cell that is whole elsewhere, another
/// program or instruction set.
Result<MergeOutcome> merge_experiments(const std::vector<std::string>& directories, const std::string& output);

}  // namespace raylex::experiments
