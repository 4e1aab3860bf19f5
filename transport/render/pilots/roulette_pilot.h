// Which paths end at random, by what the requested channels may still receive of them.
#pragma once

#include "transport/render/pilots/pilot_paths.h"
#include "transport/render/pilots/split_pilot.h"

namespace raylex::transport {

/// From a pilot of some thousand paths that do not end at random, by the states in which they leave their vertices: the
/// mean square of what channels receive behind, relative to their means, and what following it costs. A path is to go
/// on with a chance in proportion to its throughput and to the root of the ratio of the two, which spreads a variance
/// over a cost best (Rath et al. 2022, "EARS", section 3). Cost and variance of the paths of the pilot are known under
/// any such rule, so the proportion is the one with the least product. Empty, which leaves roulette to throughput
/// alone (`below`, as WalkOptions::roulette_below), where that does not save a tenth. The rays that it traces are added
/// to `rays`.
RouletteTable choose_roulette(const IntegratorContext& context, const PathTrials& trials, const SplitChoice& splits,
                              Real below, std::uint64_t& rays);

}  // namespace raylex::transport
