// The look-up of a plan, for inlining. Include split_plans.h instead.
#pragma once

#include "display/services/split_plans.h"

namespace raylex::display {

inline std::uint32_t SplitPlans::set_of(const lpe::State* states, std::size_t count) {
    if (count != 1 || set_of_state_.empty()) return find_set(states, count);
    std::uint32_t& set = set_of_state_[states[0]];
    if (!knows(set)) set = find_set(states, 1);
    return set;
}

/// Where the search for a plan begins: Fibonacci hashing of both numbers.
inline std::size_t SplitPlans::slot_of(std::uint32_t set, std::uint64_t events) const {
    return ((events ^ (std::uint64_t{set} << 40 | set)) * 0x9E3779B97F4A7C15ull >> 32) & plan_mask_;
}

inline const SplitPlans::Plan& SplitPlans::plan(std::uint32_t set, std::uint64_t events, std::size_t lobes) {
    for (std::size_t at = slot_of(set, events);; at = (at + 1) & plan_mask_) {
        const Plan& plan = plans_[at];
        if (plan.before == set && plan.events == events && plan.lobes == lobes) return plan;
        if (plan.before == unknown_set) return make(set, events, lobes);
    }
}

}  // namespace raylex::display
