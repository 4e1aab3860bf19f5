// The look-up of a plan, for inlining. Include split_plans.h instead.
#pragma once

#include "display/services/split_plans.h"

namespace raylex::display {

inline const SplitPlans::Plan& SplitPlans::plan(std::uint32_t set, std::span<const lpe::EventClass> events) {
    std::uint64_t key = std::uint64_t{events[0]} << 16 | events[1];
    for (std::size_t j = 2; j < events.size(); ++j) key = key << 16 | events[j];
    const auto lobes = static_cast<std::uint32_t>(events.size());
    // Fibonacci hashing of both numbers.
    std::size_t at = ((key ^ (std::uint64_t{set} << 40 | set)) * 0x9E3779B97F4A7C15ull >> 32) & (slots_.size() - 1);
    while (slots_[at].set != unknown_set) {
        const Slot& slot = slots_[at];
        if (slot.set == set && slot.events == key && slot.lobes_and_plan >> 28 == lobes)
            return plans_[slot.lobes_and_plan & 0xFFFFFFFu];
        at = (at + 1) & (slots_.size() - 1);
    }
    return make(set, events, key);
}

}  // namespace raylex::display
