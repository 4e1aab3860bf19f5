#include "transport/render/render.h"

#include <algorithm>
#include <set>
#include <thread>

#include "transport/render/built_scene.h"
#include "transport/render/clock.h"
#include "transport/render/render_loop.h"

namespace raylex::transport {
namespace {

/// Beauty first when it is wanted, then the settings' channels; names are unique and AOVs known.
Status resolve_channels(const RenderSettings& settings, RenderJob& job) {
    std::set<std::string> names;
    if (settings.beauty) {
        display::ChannelDefinition beauty;
        beauty.name = "beauty";
        beauty.style = display::ChannelStyle::expression;
        beauty.expression = "C.*";
        beauty.space = "rendering colour space";
        beauty.statistics = true;
        job.beauty = 0;
        job.channels.push_back(beauty);
        names.insert(beauty.name);
    }
    const std::size_t shift = job.channels.size();
    for (display::ChannelDefinition channel : settings.channels) {
        if (!names.insert(channel.name).second)
            return error_at({}, "the channel name '" + channel.name + "' is used twice; expected every name once");
        if (channel.style == display::ChannelStyle::name) {
            auto known = geoaovs::channel_definition(channel.name);
            if (!known) return known.error();
            known->statistics = channel.statistics;
            channel = *std::move(known);
        }
        for (std::size_t& index : channel.rest_of) index += shift;
        job.channels.push_back(std::move(channel));
    }
    if (job.channels.empty()) return error_at({}, "nothing to render: no beauty and no channel; expected at least one");
    return success();
}

Status resolve_filter(const SceneEntity& entity, RenderJob& job, std::vector<Error>& warnings) {
    ParameterSet parameters = entity.parameters;
    if (parameters.location.file.empty()) parameters.location = entity.location;
    auto filter =
        display::make_pixel_filter(entity.type.empty() ? "gaussian" : entity.type, parameters);  // pbrt's default
    if (!filter) return filter.error();
    for (const Parameter* p : parameters.unused())
        warnings.push_back(error_at(
            p->location, "pixel filter '" + entity.type + "' has no parameter '" + p->name + "'; it is ignored"));
    job.filter = std::make_unique<display::PixelFilter>(*std::move(filter));
    return success();
}

Status resolve_sampler(const SceneEntity& entity, const RenderSettings& settings, RenderJob& job, std::string& name,
                       std::vector<Error>& warnings) {
    auto choice = choose_sampler(entity);
    if (!choice) return choice.error();
    warnings.insert(warnings.end(), choice->warnings.begin(), choice->warnings.end());
    for (const Parameter* p : entity.parameters.unused())
        warnings.push_back(
            error_at(p->location, "sampler '" + entity.type + "' has no parameter '" + p->name + "'; it is ignored"));
    job.sampler = choice->kind;
    job.seed = settings.seed + choice->seed;
    job.samples_per_pixel = settings.samples_per_pixel.value_or(choice->samples_per_pixel);
    if (job.samples_per_pixel == 0) return error_at({}, "0 samples per pixel; expected at least 1");
    name = choice->name;
    return success();
}

}  // namespace

Result<RenderOutput> render(const BuiltScene& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    RenderJob job;
    std::vector<Error> warnings = scene.warnings;
    auto film = read_film(scene.film, settings.resolution, warnings);
    if (!film) return film.error();
    job.film = *film;
    auto camera = PerspectiveCamera::build(scene.camera, scene.camera_to_world, film->width, film->height, warnings);
    if (!camera) return camera.error();
    job.camera = std::make_unique<PerspectiveCamera>(*std::move(camera));
    const SceneEntity& filter = settings.filter ? *settings.filter : scene.filter;
    if (Status s = resolve_filter(filter, job, warnings); !s) return s.error();
    std::string sampler_name;
    if (Status s = resolve_sampler(settings.sampler ? *settings.sampler : scene.sampler, settings, job, sampler_name,
                                   warnings);
        !s)
        return s.error();
    if (Status s = resolve_channels(settings, job); !s) return s.error();
    auto chosen = choose_integrator(settings.integrator ? *settings.integrator : scene.integrator, settings.max_depth);
    if (!chosen) return chosen.error();
    warnings.insert(warnings.end(), chosen->warnings.begin(), chosen->warnings.end());
    job.integrator = chosen->integrator.get();
    auto lpe = display::LpeSetup::build(job.channels, job.beauty);
    if (!lpe) return lpe.error();
    job.lpe = std::make_unique<display::LpeSetup>(*std::move(lpe));
    if (settings.picked_lobes) job.attribution = display::LpeServices::Attribution::picked;
    if (settings.sample_filter) {
        auto made = display::make_sample_filter(settings.sample_filter->type, settings.sample_filter->parameters,
                                                {job.channels, job.beauty});
        if (!made) return made.error();
        job.sample_filter = *std::move(made);
    }
    job.threads =
        settings.threads > 0 ? settings.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    job.has_alpha = scene.view().geometry->has_alpha();

    const EventTable events(*job.lpe, scene.view());
    const geoaovs::GeometricAovs aovs(job.channels);
    IntegratorContext context;
    context.scene = scene.view();
    context.events = &events;
    context.aovs = &aovs;
    context.channels = job.channels;
    job.camera->rigid_world_to_camera(context.world_to_camera);
    context.beauty = job.beauty >= 0;
    context.batch_capacity = RenderLoop::batch_capacity;
    if (Status s = job.integrator->prepare(context); !s) return s.error();

    display::FrameBufferLayout layout;
    layout.width = film->width;
    layout.height = film->height;
    layout.block_size = RenderLoop::block_size;
    auto frame_buffer = display::FrameBuffer::create(layout, job.channels);
    if (!frame_buffer) return frame_buffer.error();

    const Stopwatch watch;
    RenderLoop loop(job, *frame_buffer);
    if (Status s = loop.run(progress, stop); !s) return s.error();
    RenderStatistics statistics;
    statistics.build_seconds = scene.build_seconds;
    statistics.build_cpu_seconds = scene.build_cpu_seconds;
    statistics.render_seconds = watch.wall();
    loop.collect(statistics);
    statistics.invalid_samples += frame_buffer->rejected_count();

    RenderOutput output{.frame_buffer = *std::move(frame_buffer),
                        .beauty = job.beauty,
                        .statistics = std::move(statistics),
                        .complete = loop.complete(),
                        .width = film->width,
                        .height = film->height,
                        .threads = job.threads,
                        .samples_per_pixel = job.samples_per_pixel,
                        .seed = settings.seed,
                        .integrator = chosen->name,
                        .sampler = sampler_name,
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
    return render(**built, settings, progress, stop);
}

}  // namespace raylex::transport
