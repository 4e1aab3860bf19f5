// Russian roulette by the light that the requested channels may still receive from a path, for renders without beauty.
// It is the dual of splitting (Bolin and Meyer 1997; Rath et al. 2022, "EARS"). The state of a path is that of its
// tracker, and whether its last direction was specular.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "transport/math/real.h"

namespace raylex::transport {

/// Maps states of paths to factors of their throughput for roulette.
class RouletteTable {
  public:
    static constexpr std::size_t most_states = 256;  ///< other states are left to plain roulette
    /// The smallest probability of going on: every survivor represents at most 8 paths, so no light is found too
    /// rarely.
    static constexpr Real least_chance = Real(0.125);

    [[nodiscard]] bool empty() const { return count_ == 0; }
    /// `state`: not 0, and not in the table. Returns false if the table is full.
    bool add(std::uint64_t state, Real strength) {
        if (count_ == most_states) return false;
        std::size_t at = place_of(state);
        states_[at] = state;
        strengths_[at] = strength;
        ++count_;
        return true;
    }
    /// The probability with which a path of this throughput goes on; 0: the state is not in the table.
    [[nodiscard]] Real chance(std::uint64_t state, Real throughput) const {
        const std::size_t at = place_of(state);
        if (state == 0 || states_[at] != state) return 0;
        return std::clamp(throughput * strengths_[at], least_chance, Real(1));
    }

  private:
    static constexpr std::size_t slots = 2 * most_states;  // half of them stay free, which ends every search
    [[nodiscard]] std::size_t place_of(std::uint64_t state) const {
        std::size_t at = state >> 32 & (slots - 1);
        while (states_[at] != 0 && states_[at] != state) at = (at + 1) & (slots - 1);
        return at;
    }
    std::array<std::uint64_t, slots> states_{};
    std::array<Real, slots> strengths_{};
    std::size_t count_ = 0;
};

}  // namespace raylex::transport
