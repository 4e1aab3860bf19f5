// A study on Slurm: its job files, and what Slurm knows of its jobs. Slurm's own programs do the rest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/cluster/command_plan.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct SlurmRequest {
    std::string directory;             ///< of the study, as a whole path
    std::string form = "slurm";        ///< the template's name or file
    std::vector<std::string> options;  ///< of sbatch, for all jobs: "--partition=long"
};

/// The jobs of one submission. Ids are empty where there is no such job.
struct Submission {
    std::string submitted;  ///< UTC
    std::string references, shards, merge;
    unsigned count = 0;  ///< shards in all
    [[nodiscard]] std::vector<std::string> ids() const;
};

/// DIR/submission.json; nothing when there is none. Errors: damaged.
Result<std::vector<Submission>> read_submission(const std::string& directory);
Status write_submission(const std::string& directory, const Submission& submission);

/// The job files of a plan, in DIR/slurm: commands.txt (a shard a line), references.sh, shards.sh (an array), merge.sh.
/// `wanted` are the numbers of the shards that the array has.
Status write_slurm_files(const SlurmRequest& request, const CommandPlan& plan, const std::vector<unsigned>& wanted);

/// Hands them to sbatch. Errors: there is no sbatch, or it refuses; then nothing stays in the queue, and `hint` says
/// how the files are used by hand.
Result<Submission> submit_to_slurm(const std::string& directory, bool references, unsigned count);

/// What squeue says of the tasks of these jobs: "123_4" -> "RUNNING". Finished ones are not there. An Error where
/// squeue cannot be asked.
Result<std::map<std::string, std::string>> slurm_queue(const std::vector<std::string>& jobs);

}  // namespace raylex::experiments
