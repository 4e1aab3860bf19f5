// A study as commands for many machines: the references first, its cells in shards, what merges them.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "experiments/cluster/command_plan.h"
#include "experiments/study/plan/config.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct StudyCommandsRequest {
    std::string directory;  ///< of all of it, as a whole path
    unsigned shards = 1, split_cells = 1;
    unsigned threads = 0;             ///< of each shard; 0: as the config says
    std::vector<std::string> config;  ///< CONFIG.toml and its --set, standing alone
    bool calibrate = true, report = true;
    bool retry = false;  ///< cells that failed are run again
};

/// Where the parts of such a study are.
struct StudyFolders {
    std::string references, reference_run, parts, results;
    explicit StudyFolders(const std::string& directory);
    [[nodiscard]] std::string part(unsigned shard) const { return parts + "/" + std::to_string(shard); }
};

/// Errors: the plan has fewer cells and parts than shards; no scene of it can be loaded.
Result<CommandPlan> study_commands(const ExperimentConfig& config, const StudyCommandsRequest& request,
                                   const std::atomic<bool>* stop);

}  // namespace raylex::experiments
