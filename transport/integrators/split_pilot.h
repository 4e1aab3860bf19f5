// Into how many rays paths are split.
#pragma once

#include <memory>

#include "transport/integrators/integrator.h"
#include "transport/paths/splits.h"

namespace raylex::transport {

/// Makes integrators that follow a plan.
class SplitTrials {
  public:
    /// Ready to integrate, of at most `most_depth` scattering events.
    [[nodiscard]] virtual std::unique_ptr<Integrator> trial(const SplitPlan& plan, std::uint32_t most_depth) const = 0;

  protected:
    ~SplitTrials() = default;
};

/// The plan with the least product of cost (rays) and variance of the requested channels, each relative to its mean, by
/// a pilot of some thousand paths that are split in two. With cost c and variance v, before and behind the split, n
/// rays make (c_before + n c_behind) (v_before + v_behind / n) (Arvo and Kirk 1990; Rath et al. 2022, "EARS", section
/// 3): v_behind is half of the mean square by which the two rays differ. Every doubling has to save a tenth more. Both
/// lobes of specular vertices are followed where that costs little.
SplitPlan choose_splits(const IntegratorContext& context, const SplitTrials& trials);

}  // namespace raylex::transport
