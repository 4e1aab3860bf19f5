// Merges results of several machines or sessions into one directory.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct MergeOutcome {
    std::size_t done = 0, failed = 0, missing = 0;
};

/// Copies the finished and failed cells and the references of all directories unchanged into a new one; the order of
/// the directories does not matter. Errors, before anything is written: different configs or scenes, a cell finished in
/// two of them, two cells with one seed, an existing output directory. A cell that failed in one directory and is
/// finished in another is finished. Parts of a cell (run_parts.h) become the cell, bit-identical to a single run, with
/// summed times. Errors: duplicate or missing samples, a cell that is complete elsewhere, another program or
/// instruction set.
Result<MergeOutcome> merge_experiments(const std::vector<std::string>& directories, const std::string& output);

}  // namespace raylex::experiments
