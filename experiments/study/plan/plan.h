// All cells of an experiment, in the order in which they are run, each with its seed.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/plan/config.h"

namespace raylex::experiments {

struct PlannedCell {
    Cell cell;                           ///< what a plan says: no results
    std::size_t scene = 0, variant = 0;  ///< in the config's lists
};

struct Plan {
    /// Replicates outermost, then scenes, budgets and methods: what is compared is run close together, so that a
    /// machine that slows down in an hour slows all methods down.
    std::vector<PlannedCell> cells;
    std::vector<std::string> notes;              ///< what is left out by itself, and why
    std::vector<std::uint64_t> reference_seeds;  ///< [scene]
};

/// Errors: an [[exclude]] that excludes nothing, no cell left, more than 1,000,000 of them.
Result<Plan> make_plan(const ExperimentConfig& config);

/// A seed of 63 bits for a purpose ("cell", "reference", "calibration"): the hash of it all. `attempt` gives another.
std::uint64_t seed_for(std::uint64_t config_seed, const std::string& purpose, const std::string& what,
                       unsigned attempt = 0);
/// What external renderers get, whose seeds are often 32-bit integers. No two cells or references of a plan share it.
std::uint32_t short_seed(std::uint64_t seed);

/// "16spp", "2.5s", "e0.01".
std::string budget_text(BudgetKind kind, double budget);

}  // namespace raylex::experiments
