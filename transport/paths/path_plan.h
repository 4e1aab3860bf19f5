// How a render spends its rays where channels alone decide that: which technique last vertices use, where paths are
// split, how roulette is played. The preparation of a render makes the plan from pilots (render/pilots/). With beauty
// the plan changes nothing: beauty's numbers do not depend on channels (Law 2).
#pragma once

#include <cstdint>
#include <memory>

#include "transport/paths/roulette.h"

namespace raylex::transport {

class LiveLights;

/// Probabilities with which a last vertex takes a light sample and traces a scattering ray. Channels take light that
/// arrives at a last vertex, and nothing that is scattered further. The weights of multiple importance sampling use the
/// densities times these shares.
struct TechniqueShares {
    Real light = 1, ray = 1;

    [[nodiscard]] bool any() const { return light < 1 || ray < 1; }
};

/// How camera subpaths are split (splits.h).
struct SplitPlan {
    /// Number of rays from the first vertex that is not purely specular, where a channel takes paths that scatter
    /// again. A power of two.
    std::uint8_t rays = 1;
    /// Number of specular vertices behind that vertex at which both the reflected and the transmitted ray are followed.
    std::uint8_t both_lobes = 0;
    /// Which of two rays a pilot follows, to measure what each brings. `none`: paths end at the split. Images follow
    /// all rays.
    enum class Only : std::uint8_t { all, first, second, none } only = Only::all;

    [[nodiscard]] bool any() const { return rays > 1 || both_lobes > 0; }
};

struct PathPlan {
    TechniqueShares shares;
    std::shared_ptr<const LiveLights> lights;  ///< as DirectLight builds them; null: not built yet
    SplitPlan splits;
    RouletteTable roulette;          ///< empty: roulette is played by throughput alone
    PathWatch* watch = nullptr;      ///< of a pilot; its paths do not end at random
    std::uint32_t most_depth = ~0u;  ///< bound on scattering events, of a pilot

    /// Whether the plan changes which rays go on from a vertex.
    [[nodiscard]] bool changes_paths() const { return splits.any() || !roulette.empty() || watch != nullptr; }
};

}  // namespace raylex::transport
