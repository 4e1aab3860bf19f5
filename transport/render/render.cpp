#include "transport/render/render.h"

#include <algorithm>
#include <new>

#include "display/services/hash64.h"
#include "transport/render/built_scene.h"
#include "transport/render/checkpoint.h"
#include "transport/render/clock.h"
#include "transport/render/render_loop.h"
#include "transport/render/resolve_render.h"
#include "transport/render/sample_limit.h"
#include "transport/scene/scene_hash.h"

namespace raylex::transport {
namespace {

/// Buffers for the sets of mattes asked for.
Status make_cryptomatte(const RenderSettings& settings, const BuiltScene& scene, RenderJob& job,
                        std::vector<Error>& warnings) {
    try {
        for (const geoaovs::MatteKind kind : settings.cryptomatte)
            job.cryptomatte.emplace_back(kind, settings.cryptomatte_ranks, job.film.width, job.film.height,
                                         scene.surface_names().of(kind));
    } catch (const std::bad_alloc&) {
        return error_at({}, "not enough memory for cryptomatte; expected about 64 bytes a pixel and set of mattes");
    }
    for (geoaovs::Cryptomatte& matte : job.cryptomatte) {
        job.sinks.push_back(&matte.coverage());
        for (const auto& [first, second] : matte.collisions())
            warnings.push_back(error_at(
                {}, "'" + first + "' and '" + second + "' have the same hash and share a matte of " + matte.name()));
    }
    return success();
}

bool asks_for(std::span<const display::ChannelDefinition> channels,
              std::span<const display::ChannelDefinition> patterns) {
    return std::any_of(channels.begin(), channels.end(), [&](const display::ChannelDefinition& channel) {
        return channel.style == display::ChannelStyle::name &&
               std::any_of(patterns.begin(), patterns.end(),
                           [&](const auto& each) { return each.name == channel.name; });
    });
}

/// What an integrator sees of the render; without events and AOVs.
IntegratorContext context_of(const BuiltScene& scene, const RenderJob& job) {
    IntegratorContext context;
    context.scene = scene.view();
    context.channels = job.channels;
    job.camera->rigid_world_to_camera(context.world_to_camera);
    context.pixel_size = job.camera->pixel_size();
    context.beauty = job.beauty >= 0;
    context.batch_capacity = RenderLoop::batch_capacity;
    context.camera = job.camera.get();
    context.width = job.film.width;
    context.height = job.film.height;
    context.filter_radius = {job.filter->radius_x(), job.filter->radius_y()};
    const auto tiles_of = [](int size, int padding) {
        return static_cast<std::uint32_t>((size + 2 * padding + RenderLoop::tile_size - 1) / RenderLoop::tile_size);
    };
    context.tiles = tiles_of(job.film.width, job.padding_x) * tiles_of(job.film.height, job.padding_y);
    context.seed = job.seed;
    context.lpe = job.lpe.get();
    context.attribution = job.attribution;
    context.pattern_channels = asks_for(job.channels, scene.pattern_channels());
    return context;
}

/// What the caller learns before the first ray, memory included.
RenderPlan plan_of(const RenderSettings& settings, const RenderJob& job, const display::FrameBufferLayout& layout) {
    RenderPlan plan{.width = job.film.width,
                    .height = job.film.height,
                    .samples_per_pixel = job.samples_per_pixel,
                    .channels = job.channels,
                    .beauty = job.beauty,
                    .crop = settings.crop.value_or(display::PixelRegion{0, 0, job.film.width, job.film.height}),
                    .filter = job.filter.get(),
                    .splat = job.splat,
                    .raster = job.raster,
                    .altered = job.sample_filters.alters(),
                    .memory = display::frame_buffer_memory(layout, job.channels, job.raster)};
    for (const geoaovs::MatteKind kind : settings.cryptomatte)
        plan.memory.push_back(
            {geoaovs::matte_layer(kind), display::RankedCoverage::expected_bytes(job.film.width, job.film.height)});
    if (settings.adaptive)  // an error and a decision a pixel
        plan.memory.push_back(
            {"adaptive", 9 * static_cast<std::uint64_t>(job.film.width) * static_cast<std::uint64_t>(job.film.height)});
    const std::uint64_t image_bytes = display::total_bytes(plan.memory);
    if (settings.checkpoint) plan.memory.push_back({"checkpoint", image_bytes});
    if (settings.limit && settings.limit->seconds > 0) plan.memory.push_back({"image before the pass", image_bytes});
    return plan;
}

}  // namespace

Result<RenderOutput> render(const BuiltScene& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    const Stopwatch since_call;
    std::vector<Error> warnings = scene.warnings;
    auto resolved = resolve_render(scene, settings, warnings);
    if (!resolved) return resolved.error();
    RenderJob& job = resolved->job;

    const EventTable events(*job.lpe, scene.view(), settings.lobe_slots);
    const geoaovs::GeometricAovs aovs(job.channels);
    job.aovs = &aovs;
    IntegratorContext context = context_of(scene, job);
    context.events = &events;
    context.aovs = &aovs;
    if (Status s = job.integrator->prepare(context); !s) return s.error();
    for (std::string& omission : job.integrator->omissions()) warnings.push_back(error_at({}, std::move(omission)));

    display::FrameBufferLayout layout;
    layout.width = job.film.width;
    layout.height = job.film.height;
    layout.block_size = RenderLoop::block_size;
    if (settings.before_rendering)
        if (Status s = settings.before_rendering(plan_of(settings, job, layout), job.sinks); !s) return s.error();
    display::RecordIdentity identity;
    if (settings.checkpoint) identity = render_identity(job, settings, scene.isa());
    auto frame_buffer = display::FrameBuffer::create(layout, job.channels, job.splat ? job.filter.get() : nullptr,
                                                     job.raster ? job.filter.get() : nullptr);
    if (!frame_buffer) return frame_buffer.error();

    // Filters and deep images, which before_rendering() has added, look at samples one by one; cryptomattes do not.
    // With holdouts light is sent apart once one is met, and its sums would round as the batches happened to be.
    if (job.sample_filters.empty() && job.sinks.empty() && !scene.view().geometry->has_holdouts())
        job.splat_sets =
            std::make_unique<display::SplatSets>(job.lpe->splat_sets(frame_buffer->sums_only(), layout.block_size));
    if (Status s = make_cryptomatte(settings, scene, job, warnings); !s) return s.error();

    if (settings.adaptive)
        job.adaptive = std::make_unique<display::AdaptiveSampler>(*settings.adaptive, job.channels, job.beauty, layout);

    RenderPosition position;
    if (settings.checkpoint) {
        if (Status s = check_checkpoint(*settings.checkpoint, job, resolved->chosen.name); !s) return s.error();
        if (settings.checkpoint->resume) {
            auto restored = restore_checkpoint(*settings.checkpoint, identity, job, *frame_buffer);
            if (!restored) return restored.error();
            position = *std::move(restored);
        }
    }
    if (job.splat_sets) frame_buffer->expect(*job.splat_sets);
    const std::uint64_t resumed_samples = position.statistics.camera_samples;
    const Stopwatch watch;
    job.seconds_before_loop = since_call.wall();
    const std::uint64_t untraced_before = scene.view().geometry->untraced_rays();
    RenderLoop loop(job, *frame_buffer);
    if (settings.checkpoint && settings.checkpoint->resume) loop.resume(std::move(position));
    if (settings.checkpoint) loop.save_to(*settings.checkpoint, std::move(identity));
    if (Status s = loop.run(progress, stop); !s) return s.error();
    for (Error error : loop.checkpoint_failures()) {
        error.message = "a checkpoint could not be saved: " + error.message;
        warnings.push_back(std::move(error));
    }
    if (const std::uint64_t untraced = scene.view().geometry->untraced_rays() - untraced_before; untraced > 0)
        warnings.push_back(error_at({},
                                    std::to_string(untraced) +
                                        " rays began or pointed beyond what can be traced (1e18, less where "
                                        "instances shrink), or were not of numbers, and were taken to hit nothing",
                                    "another unit of length, or a smaller scene, brings rays into range"));
    RenderStatistics statistics;
    statistics.build_seconds = scene.build_seconds;
    statistics.build_cpu_seconds = scene.build_cpu_seconds;
    statistics.render_seconds = watch.wall();
    loop.collect(statistics);
    statistics.invalid_samples += frame_buffer->rejected_count();
    for (std::size_t i = 0; i < job.channels.size(); ++i)
        statistics.invalid_by_channel[i] += frame_buffer->rejected_count(static_cast<display::ChannelId>(i));
    for (std::string& refused : display::refusal_warnings(job.channels, statistics.refusals))
        warnings.push_back(error_at({}, std::move(refused)));

    RenderOutput output{.frame_buffer = *std::move(frame_buffer),
                        .cryptomatte = std::move(job.cryptomatte),
                        .beauty = job.beauty,
                        .statistics = std::move(statistics),
                        .complete = loop.complete(),
                        .width = job.film.width,
                        .height = job.film.height,
                        .threads = job.threads,
                        .samples_per_pixel = loop.samples_per_pixel(),
                        .adaptive = loop.error(),
                        .unconverged_pixels = job.adaptive ? job.adaptive->unconverged() : 0,
                        .resumed_samples = resumed_samples,
                        .seed = settings.seed,
                        .splat = job.splat,
                        .integrator = resolved->chosen.name,
                        .sampler = resolved->sampler,
                        .filter = job.filter->name(),
                        .isa = scene.isa(),
                        .world_to_camera = job.camera->world_to_camera(),
                        .world_to_screen = job.camera->world_to_screen(),
                        .warnings = std::move(warnings)};
    return output;
}

Result<RenderOutput> render(const SceneDescription& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    auto built = BuiltScene::build(scene, {settings.isa, settings.threads});
    if (!built) return built.error();
    if (!settings.checkpoint) return render(**built, settings, progress, stop);
    RenderSettings identified = settings;
    identified.checkpoint->identity.emplace_back("scene", hash_text(scene_hash(scene)));
    return render(**built, identified, progress, stop);
}

}  // namespace raylex::transport
