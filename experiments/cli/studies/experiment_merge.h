// raylex experiment merge.
#pragma once

#include <string>
#include <vector>

namespace raylex::experiments {

struct ExperimentMergeOptions {
    std::vector<std::string> directories;
    std::string output;
    unsigned shards = 0;  ///< merge DIR/1 to DIR/N of the only directory; 0: merge the directories themselves
    bool wait = false, replace = false, report = false;
};

/// Merges and returns the exit code.
int merge_study(const ExperimentMergeOptions& options);

}  // namespace raylex::experiments
