// What each effect costs: variants that force one effect (`effects = { media = false }`) and differ from another in
// nothing else, at equal samples. Off: the time that leaving it out saves, and the error that it makes. On, where the
// scene does not call for it: the time that its absence saves.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"

namespace raylex::experiments {

struct EffectCost {
    std::string effect, variant, against;  ///< `against` says nothing of the effect
    bool on = false;                       ///< forced on; else off
    Interval time;                         ///< CPU time over that of `against`, at their largest common budget
    Interval error, own_error;             ///< relative errors of the beauty there: of `variant`, of `against`
};

/// In the order of the variants.
std::vector<EffectCost> effect_costs(const Study& study, const std::string& scene);

/// HTML; empty where no effect is forced.
std::string effect_costs_table(const Study& study, const std::string& scene);
/// The error made by leaving an effect out against the time that is left.
std::optional<Plot> effect_costs_plot(const Study& study, std::size_t scene);
std::string effect_costs_id(std::size_t scene);

}  // namespace raylex::experiments
