// An experiment from its config to a directory of results.
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

/// Every `parts`-th of the list of work, one further on in each round: a study's methods take turns in the list, and
/// a shard that had the same one every time would be the slowest or the fastest.
struct Shard {
    unsigned part = 1, parts = 1;
    unsigned split_cells = 1;  ///< parts that each cell's samples are rendered in, as far as can be: cell_parts.h
    [[nodiscard]] bool has(std::size_t index) const { return (index + index / parts) % parts == part - 1; }
};
/// "2/4".
Result<Shard> parse_shard(const std::string& text, const SourceLocation& where);

struct RunRequest {
    std::string directory;
    bool resume = false;  ///< go on with results that are there
    bool retry = false;   ///< run failed cells again
    bool begin = false;   ///< with `resume`: begin where there is nothing to go on with
    bool only_references = false;
    Shard shard;
    bool quiet = false;    ///< no progress and no summary are printed
    bool isolated = true;  ///< scenes are loaded and rendered by another process, whose end is not this one's
};

/// Prints the cells, the expected time and how it was got, and the memory. Nothing is written. `calibrate`: see
/// Estimates.
Status print_plan(const ExperimentConfig& config, const std::string& directory, const Shard& shard, bool calibrate,
                  const std::atomic<bool>* stop);

struct RunOutcome {
    std::size_t done = 0, failed = 0, left = 0, splits_broken = 0;
    std::size_t references_failed = 0;
    std::size_t parts = 0;  ///< of cells, done
    bool interrupted = false;
};

/// Makes references, then runs the cells. Errors: results of another config or with finished cells (unless `resume`),
/// scenes that are not those of the results any more, half-written cells, a disk that takes nothing, no scene at all
/// that can be loaded. Finished cells stay. A scene that cannot be loaded, or ends the process that does it, fails its
/// cells.
Result<RunOutcome> run_experiment(const ExperimentConfig& config, const RunRequest& request,
                                  const std::atomic<bool>* stop);

struct ReplayOutcome {
    bool same = false;
    std::string difference;             ///< what is not the same
    std::vector<std::string> compared;  ///< the files whose bits are
};
/// Every file of a finished cell against the checksums in its cell.json; then renders it again, to the samples it
/// reached, and compares every bit of its record, its arrays and its image's pixels.
Result<ReplayOutcome> replay_cell(ExperimentConfig config, const std::string& directory, const std::string& id,
                                  const std::atomic<bool>* stop);

}  // namespace raylex::experiments
