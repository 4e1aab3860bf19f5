// All cells of an experiment in the order of execution, each with its seed.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/plan/config.h"

namespace raylex::experiments {

struct PlannedRun {
    StudyRun run;                        ///< planned values, without results
    std::size_t scene = 0, variant = 0;  ///< indices in the config's lists
};

struct Plan {
    /// Ordered by replicate, then scene, budget and method: compared renders run close together, so a machine that
    /// slows down within an hour affects all methods equally.
    std::vector<PlannedRun> runs;
    std::vector<std::string> notes;              ///< cells that were left out automatically, and why
    std::vector<std::uint64_t> reference_seeds;  ///< [scene]
};

/// Makes the plan. Errors: an [[exclude]] that excludes nothing, no remaining cell, more than 1,000,000 cells.
Result<Plan> make_plan(const ExperimentConfig& config);

/// Returns a seed of 63 bits, a hash of its arguments. `purpose` is "cell", "reference" or "calibration"; each
/// `attempt` gives another seed.
std::uint64_t seed_for(std::uint64_t config_seed, const std::string& purpose, const std::string& what,
                       unsigned attempt = 0);
/// Returns the seed for external renderers, which often accept only 32-bit integers. It is unique among the cells and
/// references of a plan.
std::uint32_t short_seed(std::uint64_t seed);

/// Returns a budget as text: "16spp", "2.5s", "e0.01".
std::string budget_text(BudgetKind kind, double budget);

}  // namespace raylex::experiments
