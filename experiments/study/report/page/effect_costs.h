// The cost of each effect, from variants that force one effect (`effects = { media = false }`) and otherwise equal
// another variant, at equal samples. Forced off: the time saved and the error made. Forced on in a scene without the
// effect: the time that its absence saves.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"

namespace raylex::experiments {

struct EffectCost {
    std::string effect, variant, against;  ///< `against` does not force the effect
    bool on = false;                       ///< forced on, otherwise off
    Interval time;                         ///< CPU time relative to `against`, at the largest common budget
    Interval error, own_error;             ///< relative errors of the beauty at that budget: of `variant`, of `against`
};

/// Returns the costs in the order of the variants.
std::vector<EffectCost> effect_costs(const Study& study, const std::string& scene);

/// Returns an HTML table; empty if no effect is forced.
std::string effect_costs_table(const Study& study, const std::string& scene);
/// Returns a plot of the error without an effect against the remaining time.
std::optional<Plot> effect_costs_plot(const Study& study, std::size_t scene);
std::string effect_costs_id(std::size_t scene);

}  // namespace raylex::experiments
