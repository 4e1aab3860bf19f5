// Chooses the number of rays into which paths are split.
#pragma once

#include "transport/render/pilots/pilot_paths.h"

namespace raylex::transport {

struct SplitChoice {
    SplitPlan plan;
    double noise = 1;  ///< variance of the channels over the variance without splits
};

/// Chooses the plan with the least product of cost (rays) and variance of the requested channels, each relative to its
/// mean. A pilot of some thousand paths, split in two, measures both. With cost c and variance v, before and behind the
/// split, n rays make (c_before + n c_behind) (v_before + v_behind / n) (Arvo and Kirk 1990; Rath et al. 2022, "EARS",
/// section 3): v_behind is half of the mean square of the difference between the two rays. Each doubling of n must save
/// a further tenth. Both lobes of specular vertices are followed if that costs little. Adds the rays that it traces to
/// `rays`.
SplitChoice choose_splits(const IntegratorContext& context, const PathTrials& trials, std::uint64_t& rays);

}  // namespace raylex::transport
