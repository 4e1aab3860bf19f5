// The stages of a render. Each is a type that the previous stage makes:
//   BuiltScene       the scene's tables, which do not depend on settings
//   ResolvedJob      settings, resolved for the scene or refused
//   PreparedJob      the integrator has prepared for the scene
//   RenderTarget     the caller has received the plan, memory is allocated
//   RenderLoop       samples by a Schedule, from the beginning or a checkpoint
//   FinishedLoop     the results of the loop
//
// A render in buckets repeats the last three for each band of rows (buckets.h).
#include "transport/render/render.h"

#include <cmath>

#include "display/services/hash64.h"
#include "transport/render/loop/buckets.h"
#include "transport/render/loop/render_output.h"
#include "transport/scene/scene_hash.h"

namespace raylex::transport {
namespace {

/// If an integrator discards all its iterations there is no image; a black one would be wrong.
Result<RenderOutput> refuse_nothing(Result<RenderOutput> output) {
    if (!output) return output;
    const RenderStatistics& statistics = output->statistics;
    if (statistics.camera_samples > 0 || statistics.discarded_samples == 0) return output;
    return error_at({},
                    "there is no image: integrator '" + output->used.integrator + "' discarded all " +
                        std::to_string(statistics.discarded_samples) + " camera samples",
                    "expected discard_iteration() for start-up iterations only");
}

Result<RenderOutput> render_all(const BuiltScene& scene, const RenderSettings& settings,
                                const std::function<void(const RenderProgress&)>& progress,
                                const std::atomic<bool>* stop) {
    const Stopwatch since_call;
    auto resolved = ResolvedJob::resolve(scene, settings);
    if (!resolved) return resolved.error();
    if (settings.before_preparing)
        if (Status s = settings.before_preparing(plan_of(*resolved)); !s) return s.error();
    auto prepared = PreparedJob::prepare(*std::move(resolved), since_call, stop);
    if (!prepared) return prepared.error();
    auto buckets = plan_buckets(*prepared);
    if (!buckets) return buckets.error();
    if (*buckets) return render_buckets(*prepared, **buckets, since_call, progress, stop);
    if (prepared->job.checkpoint && std::isinf(prepared->job.checkpoint->seconds)) prepared->job.checkpoint.reset();
    std::vector<display::SampleSink*> sinks;
    if (settings.before_rendering)
        if (Status s = settings.before_rendering(plan_of(prepared->job), sinks); !s) return s.error();
    auto target = RenderTarget::allocate(*prepared, std::move(sinks));
    if (!target) return target.error();
    const auto loop = RenderLoop::begin(*prepared, *target, since_call);
    if (!loop) return loop.error();
    prepared->unwritten.write(prepared->guide, prepared->job.warnings);
    auto finished = (*loop)->run(progress, stop);
    if (!finished) return finished.error();
    return output_of(prepared->job, *std::move(target), *std::move(finished));
}

}  // namespace

Result<RenderOutput> render(const BuiltScene& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    return refuse_nothing(render_all(scene, settings, progress, stop));
}

Result<RenderOutput> render(const SceneDescription& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    auto built = BuiltScene::build(scene, settings.machine);
    if (!built) return built.error();
    return render(scene, **built, settings, progress, stop);
}

Result<RenderOutput> render(const SceneDescription& description, const BuiltScene& scene,
                            const RenderSettings& settings, const std::function<void(const RenderProgress&)>& progress,
                            const std::atomic<bool>* stop) {
    if (!settings.checkpoint && settings.paths.guide_file.empty()) return render(scene, settings, progress, stop);
    RenderSettings identified = settings;
    identified.identity.emplace_back("scene", hash_text(scene_hash(description)));
    return render(scene, identified, progress, stop);
}

Status check_render(const BuiltScene& scene, const RenderSettings& settings) {
    const auto resolved = ResolvedJob::resolve(scene, settings);
    return resolved ? success() : resolved.error();
}

}  // namespace raylex::transport
