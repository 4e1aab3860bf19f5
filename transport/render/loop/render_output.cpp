#include "transport/render/loop/render_output.h"

namespace raylex::transport {

RenderOutput output_of(const ResolvedJob& job, RenderTarget target, FinishedLoop finished) {
    RenderOutput output{.frame_buffer = std::move(target.frame_buffer),
                        .bands = nullptr,
                        .buckets = {},
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
    output.rejected_block_sums = output.frame_buffer.rejected_count();
    output.light_magnitude = output.frame_buffer.light_magnitude();
    return output;
}

}  // namespace raylex::transport
