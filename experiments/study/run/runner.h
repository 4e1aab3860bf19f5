// Runs an experiment, from its config to a results directory.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "experiments/study/plan/config.h"
#include "experiments/study/plan/plan.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Every `parts`-th item of the list of work, shifted by one in each round. Methods alternate in the list, so without
/// the shift a shard could always get the slowest or the fastest method.
struct Shard {
    unsigned part = 1, parts = 1;
    unsigned split_runs = 1;  ///< number of parts of each cell's samples, where possible: run_parts.h
    [[nodiscard]] bool has(std::size_t index) const { return (index + index / parts) % parts == part - 1; }
};
/// Parses a shard: "2/4".
Result<Shard> parse_shard(const std::string& text, const SourceLocation& where);

struct RunRequest {
    std::string directory;
    bool resume = false;  ///< continue existing results
    bool retry = false;   ///< run failed cells again
    bool begin = false;   ///< with `resume`: start if there are no results
    bool only_references = false;
    Shard shard;
    bool quiet = false;    ///< print no progress and no summary
    bool isolated = true;  ///< load and render scenes in another process, whose crash does not end this one
};

/// Prints the cells, the expected time with its source, and the memory. Writes no file. `calibrate`: see Estimates.
Status print_plan(const ExperimentConfig& config, const std::string& directory, const Shard& shard, bool calibrate,
                  const std::atomic<bool>* stop);

struct RunOutcome {
    std::size_t done = 0, failed = 0, left = 0, splits_broken = 0;
    std::size_t references_failed = 0;
    std::size_t parts = 0;  ///< finished parts of cells
    bool interrupted = false;
};

/// Makes references, then runs the cells. Finished cells are kept. Errors: results of another config, or with finished
/// cells (unless `resume`); scenes that have changed; incomplete cells; a disk that rejects files; no scene that can be
/// loaded. A scene that cannot be loaded, or crashes its process, fails its cells.
Result<RunOutcome> run_experiment(const ExperimentConfig& config, const RunRequest& request,
                                  const std::atomic<bool>* stop);

struct ReplayOutcome {
    bool same = false;
    std::string difference;             ///< the first difference
    std::vector<std::string> compared;  ///< files with equal bits
};
/// Checks every file of a finished cell against the checksums in its cell.json. Then renders the cell again with the
/// same number of samples and compares every bit of its record, its arrays and its image's pixels.
Result<ReplayOutcome> replay_run(ExperimentConfig config, const std::string& directory, const std::string& id,
                                 const std::atomic<bool>* stop);

}  // namespace raylex::experiments
