// The stages of a render, each of a type that the one before it makes:
//
//   BuiltScene       the scene's tables, which no setting changes
//   ResolvedJob      settings resolved against it, or refused
//   PreparedJob      the integrator has seen the scene
//   RenderTarget     the caller has seen the plan, memory is taken
//   RenderLoop       samples by a Schedule, from the beginning or a checkpoint
//   FinishedLoop     what is told of the image
#include "transport/render/render.h"

#include "display/services/hash64.h"
#include "transport/render/render_loop.h"
#include "transport/scene/scene_hash.h"

namespace raylex::transport {
namespace {

/// Takes the image out of `target`.
RenderOutput output_of(const ResolvedJob& job, RenderTarget target, FinishedLoop finished) {
    RenderOutput output{.frame_buffer = std::move(target.frame_buffer),
                        .cryptomatte = std::move(target.mattes),
                        .beauty = job.channels.beauty,
                        .statistics = std::move(finished.statistics),
                        .complete = finished.complete,
                        .width = job.grid.width,
                        .height = job.grid.height,
                        .threads = job.threads,
                        .crop = job.sampling.film.crop,
                        .samples_per_pixel = finished.samples_per_pixel,
                        .adaptive = std::move(finished.error),
                        .unconverged_pixels = finished.unconverged_pixels,
                        .resumed_samples = finished.resumed_samples,
                        .seed = job.settings.seed,
                        .splat = job.sampling.splat,
                        .integrator = job.chosen.name,
                        .sampler = job.sampling.sampler_name,
                        .filter = job.sampling.filter->name(),
                        .isa = job.scene.isa(),
                        .world_to_camera = job.scene.space().from_world(job.sampling.camera->world_to_camera()),
                        .world_to_screen = job.scene.space().from_world(job.sampling.camera->world_to_screen()),
                        .warnings = job.warnings};
    for (const std::vector<Error>* more : {&target.warnings, &finished.warnings})
        output.warnings.insert(output.warnings.end(), more->begin(), more->end());
    return output;
}

}  // namespace

Result<RenderOutput> render(const BuiltScene& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    const Stopwatch since_call;
    auto resolved = ResolvedJob::resolve(scene, settings);
    if (!resolved) return resolved.error();
    const auto prepared = PreparedJob::prepare(*std::move(resolved));
    if (!prepared) return prepared.error();
    auto target = RenderTarget::allocate(*prepared);
    if (!target) return target.error();
    const auto loop = RenderLoop::begin(*prepared, *target, since_call);
    if (!loop) return loop.error();
    auto finished = (*loop)->run(progress, stop);
    if (!finished) return finished.error();
    return output_of(prepared->job, *std::move(target), *std::move(finished));
}

Result<RenderOutput> render(const SceneDescription& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    auto built = BuiltScene::build(scene, {settings.isa, settings.threads});
    if (!built) return built.error();
    return render(scene, **built, settings, progress, stop);
}

Result<RenderOutput> render(const SceneDescription& description, const BuiltScene& scene,
                            const RenderSettings& settings, const std::function<void(const RenderProgress&)>& progress,
                            const std::atomic<bool>* stop) {
    if (!settings.checkpoint) return render(scene, settings, progress, stop);
    RenderSettings identified = settings;
    identified.checkpoint->identity.emplace_back("scene", hash_text(scene_hash(description)));
    return render(scene, identified, progress, stop);
}

}  // namespace raylex::transport
