#include "transport/render/loop/render_output.h"

namespace raylex::transport {

RenderOutput output_of(const ResolvedJob& job, RenderTarget target, FinishedLoop finished) {
    const RenderSpace& space = job.scene.space();
    RenderOutput output{.frame_buffer = std::move(target.frame_buffer),
                        .buckets = {},
                        .cryptomatte = std::move(target.mattes),
                        .beauty = job.channels.beauty,
                        .sums = {},
                        .samples = std::move(finished.samples),
                        .view = {.width = job.grid.width,
                                 .height = job.grid.height,
                                 .crop = job.sampling.film.crop,
                                 .world_to_camera = space.from_world(job.sampling.camera->world_to_camera()),
                                 .world_to_screen = space.from_world(job.sampling.camera->world_to_screen())},
                        .used = {.integrator = job.chosen.name,
                                 .sampler = job.sampling.sampler_name,
                                 .filter = job.sampling.filter->name(),
                                 .isa = job.scene.isa(),
                                 .splat = job.sampling.splat,
                                 .threads = job.threads,
                                 .seed = job.settings.samples.seed},
                        .statistics = std::move(finished.statistics),
                        .warnings = job.warnings};
    for (const std::vector<Error>* more : {&target.warnings, &finished.warnings})
        output.warnings.insert(output.warnings.end(), more->begin(), more->end());
    output.sums = {.rejected = output.frame_buffer.rejected_count(),
                   .light_magnitude = output.frame_buffer.light_magnitude()};
    return output;
}

}  // namespace raylex::transport
