// Renders the passes of a job one after the other and sums their images.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "experiments/job/passes/pass_plan.h"
#include "lpe/result.h"
#include "transport/render/built_scene.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// The header attribute with the record of every pass, a line each.
inline constexpr const char* passes_attribute = "raylex/passes";

/// What a pass rendered.
struct PassRecord {
    std::string name, method;
    double samples_per_pixel = 0;  ///< finished; 0: the pass was not rendered
    double cpu_seconds = 0;
    std::string text{};  ///< the record as a line
};

struct JobOutput {
    transport::RenderOutput output;    ///< of passes: the sum; statistics of all passes together
    std::vector<PassRecord> passes{};  ///< in the order of the plan; empty without passes
    [[nodiscard]] std::string pass_lines() const;
};

/// Renders a job. Without passes this is transport::render(). Pass k has random numbers of its own, and pass 0 those of
/// a render without passes. The pass with the AOVs is rendered first: it calls RenderSettings::before_rendering with
/// the channels of the sum. Values are summed in the order of the passes, in double, so the bits do not depend on
/// threads.
/// `*stop` ends all passes; the sum then lacks the light of those that had not begun, and is marked incomplete.
Result<JobOutput> render_job(const Job& job, const PassPlan& plan, const transport::SceneDescription& scene,
                             const transport::BuiltScene& built,
                             const std::function<void(const transport::RenderProgress&)>& progress,
                             const std::atomic<bool>* stop);

}  // namespace raylex::experiments
