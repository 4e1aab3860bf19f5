// Runs a study on Slurm: writes job files, and reads the state of jobs, by Slurm's own programs.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/cluster/command_plan.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct SlurmRequest {
    std::string directory;             ///< absolute path of the study's directory
    std::string form = "slurm";        ///< name or file of the template
    std::vector<std::string> options;  ///< options of sbatch for all jobs: "--partition=long"
};

/// The jobs of one submission. An id is empty if there is no such job.
struct Submission {
    std::string submitted;  ///< time in UTC
    std::string references, shards, merge;
    unsigned count = 0;  ///< number of shards
    [[nodiscard]] std::vector<std::string> ids() const;
};

/// Reads DIR/submission.json; empty if it does not exist. Errors: the file is damaged.
Result<std::vector<Submission>> read_submission(const std::string& directory);
Status write_submission(const std::string& directory, const Submission& submission);

/// Writes the job files of a plan to DIR/slurm: commands.txt (one shard per line), references.sh, shards.sh (an array),
/// merge.sh. `wanted` are the numbers of the shards in the array.
Status write_slurm_files(const SlurmRequest& request, const CommandPlan& plan, const std::vector<unsigned>& wanted);

/// Submits the job files with sbatch. Errors: sbatch is missing or rejects a job; then nothing stays in the queue, and
/// `hint` explains how to submit the files by hand.
Result<Submission> submit_to_slurm(const std::string& directory, bool references, unsigned count);

/// Returns the states of the tasks of these jobs, from squeue: "123_4" -> "RUNNING". Finished tasks are missing.
/// Returns an Error if squeue fails.
Result<std::map<std::string, std::string>> slurm_queue(const std::vector<std::string>& jobs);

}  // namespace raylex::experiments
