// raylex experiment merge.
#pragma once

#include <string>
#include <vector>

namespace raylex::experiments {

struct ExperimentMergeOptions {
    std::vector<std::string> directories;
    std::string output;
    unsigned shards = 0;  ///< DIR/1 to DIR/N of the one directory that is named; 0: the directories themselves
    bool wait = false, replace = false, report = false;
};

/// The exit code.
int merge_study(const ExperimentMergeOptions& options);

}  // namespace raylex::experiments
