// Splits a study into commands for many machines: the references first, then the cells in shards, then the merge.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "experiments/cluster/command_plan.h"
#include "experiments/study/plan/config.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct StudyCommandsRequest {
    std::string directory;  ///< absolute path of the study's directory
    unsigned shards = 1, split_runs = 1;
    unsigned threads = 0;             ///< threads of each shard; 0: the config's number
    std::vector<std::string> config;  ///< CONFIG.toml and its --set, with absolute paths
    bool calibrate = true, report = true;
    bool retry = false;  ///< failed cells run again
};

/// The folders of the parts of a study.
struct StudyFolders {
    std::string references, reference_run, parts, results;
    explicit StudyFolders(const std::string& directory);
    [[nodiscard]] std::string part(unsigned shard) const { return parts + "/" + std::to_string(shard); }
};

/// Makes the commands. Errors: the plan has fewer cells and parts than shards; no scene of it can be loaded.
Result<CommandPlan> study_commands(const ExperimentConfig& config, const StudyCommandsRequest& request,
                                   const std::atomic<bool>* stop);

}  // namespace raylex::experiments
