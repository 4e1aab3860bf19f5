// How a render without beauty spends its rays: which technique last vertices use, where paths are split, how Russian
// roulette decides. The preparation of a render makes the plan from pilots (render/pilots/). With beauty the plan
// changes nothing: the samples of beauty do not depend on channels (Law 2).
#pragma once

#include <cstdint>
#include <memory>

#include "transport/paths/plan/roulette.h"

namespace raylex::transport {

class LiveLights;

/// The probabilities with which a vertex takes a light sample and traces a scattering ray. A plan has them for last
/// vertices: there, channels take light that arrives from an emitter, and no light that is scattered again before. The
/// weights of multiple importance sampling use the densities times these shares.
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
    /// Which of two rays are followed; pilots measure costs with it. `none`: paths end at the vertex where they would
    /// split.
    enum class Only : std::uint8_t { all, first, none } only = Only::all;

    [[nodiscard]] bool any() const { return rays > 1 || both_lobes > 0; }
};

struct PathPlan {
    TechniqueShares shares;
    std::shared_ptr<const LiveLights> lights;  ///< choosers of lights; null: DirectLight builds them
    SplitPlan splits;
    RouletteTable roulette;  ///< empty: roulette depends on throughput alone
    // For pilots.
    bool follows_whole_paths = false;  ///< paths do not end at random, and SplitState marks where they could split
    std::uint32_t most_depth = ~0u;    ///< bound on scattering events

    /// Whether the plan changes which rays go on from a vertex.
    [[nodiscard]] bool changes_paths() const { return splits.any() || !roulette.empty() || follows_whole_paths; }
};

}  // namespace raylex::transport
