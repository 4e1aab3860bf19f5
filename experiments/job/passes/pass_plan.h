// Plans the passes of a render: proves that their classes partition the beauty and that each method samples its class,
// and restricts every channel to the class of each pass.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "display/services/channel.h"
#include "experiments/job/channels/channel_plan.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// One render of a sequence.
struct PlannedPass {
    std::string name;
    transport::SceneEntity method;
    std::string takes;       ///< as requested
    std::string expression;  ///< the class of paths, in the dialect renderman
    std::optional<std::uint64_t> samples_per_pixel;
    double time_share = 1;                               ///< fraction of a time limit
    bool has_halves = false;                             ///< is rendered in two halves, for statistics
    bool has_aovs = false;                               ///< supplies everything that is not light of the beauty
    std::vector<display::ChannelDefinition> channels{};  ///< for ChannelSettings::list
};

/// The passes of a job. Without passes the plan is empty, and the job is one render.
struct PassPlan {
    std::vector<PlannedPass> passes;  ///< one alone takes all paths: its image has the bits of a render without passes
    std::vector<std::string> notes;   ///< for the user, before the render
    std::string refuted;  ///< not empty: the classes are no partition, or a method misses paths of its class
    [[nodiscard]] std::size_t with_aovs() const;
};

/// Prepares a job with passes, before its scene is loaded: the integrator becomes that of the pass with the AOVs.
/// Errors name settings that passes do not support.
Status begin_passes(Job& job);

/// Plans the passes of a job and, if the job requests them, adds their layers to `channels`. Errors: `takes` is not
/// valid, or methods differ in the longest path. A failed proof is not an Error; it sets `refuted`.
Result<PassPlan> plan_passes(const Job& job, const transport::SceneDescription& scene, const ScenePathStrings& words,
                             ChannelPlan& channels);

}  // namespace raylex::experiments
