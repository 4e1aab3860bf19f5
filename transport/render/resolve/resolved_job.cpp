#include "transport/render/resolve/resolved_job.h"

#include <algorithm>
#include <thread>

#include "transport/render/resolve/channel_scales.h"
#include "transport/render/resolve/resolve_checks.h"

namespace raylex::transport {
namespace {

/// Refuses by name what filter mode splat does not support.
Status resolve_splat(const ChannelSettings& channels, const MatteSettings& mattes, CameraSampling& sampling) {
    sampling.splat = true;
    sampling.padding_x = display::splat_reach(sampling.filter->radius_x());
    sampling.padding_y = display::splat_reach(sampling.filter->radius_y());
    const std::string hint = "expected filter mode importance";
    if (std::max(sampling.padding_x, sampling.padding_y) > TileGrid::tile_size)
        return error_at(sampling.filter_location, "pixel filter '" + sampling.filter->name() +
                                                      "' reaches farther than " + std::to_string(TileGrid::tile_size) +
                                                      " pixels, too far for filter mode splat; " + hint);
    if (!channels.statistics.empty())
        return error_at(
            channels.statistics.front().location,
            "statistics of '" + channels.statistics.front().channel +
                "' in filter mode splat: samples are shared by neighbouring pixels, so errors cannot be estimated; " +
                hint);
    for (const display::ChannelDefinition& channel : channels.list)
        if (channel.statistics)
            return error_at(
                display::location_of(channel),
                "channel '" + channel.name + "' keeps statistics, which filter mode splat does not support; " + hint);
    if (!mattes.kinds.empty())
        return error_at({},
                        "cryptomatte in filter mode splat: coverage needs samples that belong to one pixel; " + hint);
    return success();
}

Status check_cryptomatte(const MatteSettings& mattes, const CameraSampling& sampling) {
    if (mattes.kinds.empty()) return success();
    if (sampling.filter->has_negative_lobes())
        return error_at(sampling.filter_location,
                        "pixel filter '" + sampling.filter->name() +
                            "' has negative lobes, and coverage in a cryptomatte cannot be negative; expected "
                            "box, triangle, gaussian or blackman-harris");
    const int ranks = mattes.ranks;
    if (ranks < 2 || ranks > geoaovs::Cryptomatte::most_ranks || ranks % 2 != 0)
        return error_at({}, std::to_string(ranks) + " cryptomatte ranks; expected an even number from 2 to " +
                                std::to_string(geoaovs::Cryptomatte::most_ranks));
    return success();
}

Status resolve_filter(const SceneEntity& entity, CameraSampling& sampling, std::vector<Error>& warnings) {
    ParameterSet parameters = entity.parameters;
    if (parameters.location.file.empty()) parameters.location = entity.location;
    auto filter =
        display::make_pixel_filter(entity.type.empty() ? "gaussian" : entity.type, parameters);  // pbrt's default
    if (!filter) return filter.error();
    for (const Parameter* p : parameters.unused())
        warnings.push_back(error_at(
            p->location, "pixel filter '" + entity.type + "' has no parameter '" + p->name + "'; it is ignored"));
    sampling.filter_location = entity.location;
    sampling.filter = std::make_unique<display::PixelFilter>(*std::move(filter));
    return success();
}

Status resolve_sampler(const SceneEntity& entity, const SampleSettings& settings, CameraSampling& sampling,
                       std::vector<Error>& warnings) {
    auto choice = choose_sampler(entity);
    if (!choice) return choice.error();
    for (const Parameter* p : entity.parameters.unused())
        warnings.push_back(
            error_at(p->location, "sampler '" + entity.type + "' has no parameter '" + p->name + "'; it is ignored"));
    sampling.sampler = choice->kind;
    sampling.arrangement_bits = choice->arrangement_bits;
    sampling.seed = settings.seed + choice->seed;
    sampling.samples_per_pixel = settings.per_pixel.value_or(choice->samples_per_pixel);
    if (sampling.samples_per_pixel == 0) return error_at({}, "0 samples per pixel; expected at least 1");
    sampling.sampler_name = choice->name;
    return success();
}

Result<CameraSampling> resolve_sampling(const BuiltScene& scene, const RenderSettings& settings,
                                        std::vector<Error>& warnings) {
    CameraSampling sampling;
    auto film = read_film(scene.film, settings.film.resolution, warnings);
    if (!film) return film.error();
    sampling.film = *film;
    if (settings.film.crop) sampling.film.crop = settings.film.crop;
    const bool lens_code = scene.view().general_code.contains(Effect::depth_of_field);
    auto camera = make_camera(scene.camera,
                              {scene.space().placed(scene.camera_to_world), film->width, film->height, lens_code,
                               scene.camera_motion, film->diagonal},
                              warnings);
    if (!camera) return camera.error();
    sampling.camera = *std::move(camera);
    sampling.times = scene.view().asks_for_times();
    sampling.cones = scene.view().materials->filters_images();
    const SceneEntity& filter = settings.film.filter ? *settings.film.filter : scene.filter;
    if (Status s = resolve_filter(filter, sampling, warnings); !s) return s.error();
    if (settings.film.splat)
        if (Status s = resolve_splat(settings.channels, settings.mattes, sampling); !s) return s.error();
    if (Status s = check_cryptomatte(settings.mattes, sampling); !s) return s.error();
    const SceneEntity& sampler = settings.samples.sampler ? *settings.samples.sampler : scene.sampler;
    if (Status s = resolve_sampler(sampler, settings.samples, sampling, warnings); !s) return s.error();
    return sampling;
}

/// Whether any channel needs light; AOVs do not.
bool asks_for_light(const JobChannels& channels) {
    return channels.beauty >= 0 || channels.keeps_path_strings ||
           std::any_of(channels.list.begin(), channels.list.end(), [](const display::ChannelDefinition& channel) {
               return channel.style == display::ChannelStyle::expression;
           });
}

/// A warning with the first light that emits nothing and the number of others: `scene check` names each.
Error darkness(const std::vector<Error>& dark) {
    Error first = dark.front();
    if (dark.size() == 2) first.message += ", and neither does one other light of the scene";
    if (dark.size() > 2)
        first.message += ", and neither do " + std::to_string(dark.size() - 1) + " other lights of the scene";
    return first;
}

}  // namespace

Result<ResolvedJob> ResolvedJob::resolve(const BuiltScene& scene, const RenderSettings& settings) {
    ResolvedJob job(scene, settings);
    auto sampling = resolve_sampling(scene, settings, job.warnings);
    if (!sampling) return sampling.error();
    auto chosen =
        choose_integrator(integrator_for(settings.paths.integrator, scene.integrator), settings.paths.max_depth);
    if (!chosen) return chosen.error();
    if (chosen->samples_per_pixel && !settings.samples.per_pixel)
        sampling->samples_per_pixel = *chosen->samples_per_pixel;
    job.warnings.insert(job.warnings.end(), chosen->warnings.begin(), chosen->warnings.end());
    auto channels =
        resolve_channels(settings.channels, settings.labels, scene.pattern_channels(), *chosen, sampling->splat);
    if (!channels) return channels.error();
    set_scales(scene, channels->list);
    if (asks_for_light(*channels) && !scene.dark_lights.empty()) job.warnings.push_back(darkness(scene.dark_lights));
    if (Status s = check_raster(settings.channels, *chosen, *sampling, *channels, job.warnings); !s) return s.error();
    auto budget = resolve_budget(settings.samples, settings.stop, *sampling, *chosen, *channels, job.warnings);
    if (!budget) return budget.error();
    auto grid = resolve_grid(settings.stop, *sampling, *chosen);
    if (!grid) return grid.error();
    channels->takes_all = channels->beauty >= 0 && settings.channels.takes.empty();
    const bool is_of_class = channels->beauty >= 0 && !channels->takes_all;
    auto lpe =
        display::LpeSetup::build(channels->list, channels->takes_all ? channels->beauty : display::invalid_channel,
                                 {.first_alone = is_of_class});
    if (!lpe) return lpe.error();
    channels->lpe = std::make_unique<display::LpeSetup>(*std::move(lpe));
    if (Status s = check_traits(*chosen, scene.view(), *channels); !s) return s.error();
    if (Status s = check_camera(*chosen, scene.camera, *sampling->camera); !s) return s.error();

    job.sampling = *std::move(sampling);
    job.chosen = *std::move(chosen);
    job.channels = *std::move(channels);
    job.budget = *std::move(budget);
    job.grid = *grid;
    job.threads = settings.machine.threads > 0 ? settings.machine.threads
                                               : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    job.has_extra_rows = scene.view().media->any();
    const std::string& guide = settings.paths.guide_file;
    if (!guide.empty() && job.guide_request().mode == GuideMode::off)
        return error_at(
            {guide, 0, 0},
            "integrator '" + job.chosen.name + "' learns no guide here, so it cannot use this guide file",
            "expected its parameter guide = \"auto\" or \"on\", which path and bdpt have, or no guide file");
    return job;
}

GuideRequest ResolvedJob::guide_request() const {
    GuideRequest request = integrator().guide_request();
    if (const auto samples = settings.paths.guide_samples; samples && request.mode != GuideMode::off) {
        request.mode = *samples > 0 ? GuideMode::on : GuideMode::off;
        request.samples = *samples;
    }
    return request;
}

}  // namespace raylex::transport
