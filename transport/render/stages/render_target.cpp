#include "transport/render/stages/render_target.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "transport/render/stages/checkpoint.h"

namespace raylex::transport {

display::FrameBufferLayout layout_of(const ResolvedJob& job) {
    display::FrameBufferLayout layout;
    layout.width = job.grid.width;
    layout.height = job.bucket ? job.bucket->end - job.bucket->first : job.grid.height;
    layout.first_row = job.bucket ? job.bucket->first : 0;
    layout.block_size = TileGrid::block_size;
    return layout;
}

RenderPlan plan_of(const ResolvedJob& job) {
    const display::FrameBufferLayout layout = layout_of(job);
    const RenderSettings& settings = job.settings;
    const int width = job.grid.width, height = job.grid.height;
    RenderPlan plan{.width = width,
                    .height = height,
                    .samples_per_pixel = job.budget.samples_per_pixel,
                    .channels = job.channels.list,
                    .beauty = job.channels.beauty,
                    .crop = job.sampling.film.crop.value_or(display::PixelRegion{0, 0, width, height}),
                    .filter = job.sampling.filter.get(),
                    .splat = job.sampling.splat,
                    .raster = job.raster(),
                    .signed_light = job.scene.view().wavelengths != nullptr,
                    .words = job.channels.lpe->words(),
                    .altered = job.channels.filters.alters(),
                    .memory = display::frame_buffer_memory(layout, job.channels.list, job.raster()),
                    .identity = render_identity(job),
                    .warnings = job.warnings};
    for (const geoaovs::MatteKind kind : settings.mattes.kinds)
        plan.memory.push_back({geoaovs::matte_layer(kind), display::RankedCoverage::expected_bytes(width, height)});
    if (settings.stop.adaptive)  // an error and a decision per pixel
        plan.memory.push_back({"adaptive", 9 * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height)});
    const std::uint64_t image_bytes = display::total_bytes(plan.memory);
    if (job.checkpoint && std::isfinite(job.checkpoint->seconds)) plan.memory.push_back({"checkpoint", image_bytes});
    if (settings.stop.limit && settings.stop.limit->seconds > 0)
        plan.memory.push_back({"image before the pass", image_bytes});
    return plan;
}

Status RenderTarget::make_mattes(const ResolvedJob& job) {
    try {
        for (const geoaovs::MatteKind kind : job.settings.mattes.kinds)
            mattes.emplace_back(kind, job.settings.mattes.ranks, job.grid.width, job.grid.height,
                                job.scene.surface_names().of(kind));
    } catch (const std::bad_alloc&) {
        return error_at({}, "not enough memory for cryptomatte; expected about 64 bytes a pixel and set of mattes");
    }
    for (geoaovs::Cryptomatte& matte : mattes) {
        sinks.push_back(&matte.coverage());
        for (const auto& [first, second] : matte.collisions())
            warnings.push_back(error_at(
                {}, "'" + first + "' and '" + second + "' have the same hash and share a matte of " + matte.name()));
    }
    return success();
}

Result<RenderTarget> RenderTarget::allocate(const PreparedJob& prepared, std::vector<display::SampleSink*> sinks) {
    const ResolvedJob& job = prepared.job;
    const display::FrameBufferLayout layout = layout_of(job);
    const display::PixelFilter* filter = job.sampling.filter.get();
    auto frame_buffer = display::FrameBuffer::create(layout, job.channels.list, job.sampling.splat ? filter : nullptr,
                                                     job.raster() ? filter : nullptr);
    if (!frame_buffer) return frame_buffer.error();
    RenderTarget target(*std::move(frame_buffer));
    target.sinks = std::move(sinks);
    // Filters and deep images, which before_rendering() may add, read samples one by one; cryptomattes do not. With
    // holdouts, light is split off after the first one, and the rounding of its sums would depend on batches.
    const bool sinks_read = std::any_of(target.sinks.begin(), target.sinks.end(),
                                        [](const display::SampleSink* sink) { return sink->reads_channels(); });
    if (job.channels.filters.empty() && !sinks_read && !job.scene.view().geometry->has_holdouts())
        target.splat_sets = std::make_unique<const display::SplatSets>(
            job.channels.lpe->splat_sets(target.frame_buffer.sums_only(), layout.block_size));
    if (Status s = target.make_mattes(job); !s) return s.error();
    return target;
}

}  // namespace raylex::transport
