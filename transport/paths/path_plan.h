// How a render spends its rays where channels alone decide that: which technique last vertices use, where paths are
// split, how roulette is played. The preparation of a render makes the plan from pilots (render/pilots/). With beauty
// there is no plan: beauty's numbers do not depend on channels (Law 2).
#pragma once

#include <cstdint>

#include "transport/paths/roulette.h"

namespace raylex::transport {

/// Probabilities with which a vertex that only a light can follow takes a light sample and traces a scattering ray. The
/// weights of multiple importance sampling use the densities times these shares.
struct TechniqueShares {
    Real light = 1, ray = 1;
};

/// How camera subpaths are split (splits.h).
struct SplitPlan {
    /// Rays that leave a path's first vertex with a density, if a path string may go on there. A power of two.
    std::uint8_t rays = 1;
    /// Number of specular vertices behind that vertex at which both the reflected and the transmitted ray are followed.
    std::uint8_t both_lobes = 0;
    /// Which of two rays a pilot follows, to measure what each brings. Images follow all rays.
    enum class Only : std::uint8_t { all, first, second, none } only = Only::all;

    [[nodiscard]] bool any() const { return rays > 1 || both_lobes > 0; }
};

struct PathPlan {
    TechniqueShares shares;
    SplitPlan splits;
    RouletteTable roulette;          ///< empty: roulette is played by throughput alone
    PathWatch* watch = nullptr;      ///< of a pilot; its paths do not end at random
    std::uint32_t most_depth = ~0u;  ///< bound on scattering events, of a pilot

    /// Whether the plan changes which rays go on from a vertex.
    [[nodiscard]] bool changes_paths() const { return splits.any() || !roulette.empty() || watch != nullptr; }
};

}  // namespace raylex::transport
