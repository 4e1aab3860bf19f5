// Chooses the probabilities with which paths go on, by the light that the requested channels may still receive from
// them.
#pragma once

#include "transport/render/pilots/pilot_paths.h"
#include "transport/render/pilots/split_pilot.h"

namespace raylex::transport {

/// A pilot follows some thousand paths that do not end at random. For each state in which paths leave vertices it
/// measures the mean square of what channels receive behind the vertex, relative to their means, and the cost of
/// following the path. The best probability of going on is proportional to throughput and to the root of the ratio of
/// the two (Rath et al. 2022, "EARS", section 3). Cost and variance of the pilot's paths are known under any such rule,
/// so the factor with the least product is chosen. Returns an empty table, which leaves roulette to throughput alone
/// (`below`: WalkOptions::roulette_below), if the table would not save a tenth. Adds the rays that it traces to `rays`.
RouletteTable choose_roulette(const IntegratorContext& context, const PathTrials& trials, const SplitChoice& splits,
                              Real below, std::uint64_t& rays);

}  // namespace raylex::transport
