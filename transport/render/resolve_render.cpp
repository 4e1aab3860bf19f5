#include "transport/render/resolve_render.h"

#include <algorithm>
#include <set>
#include <thread>

namespace raylex::transport {
namespace {

/// Beauty first when it is wanted, then the settings' channels, then statistics; names are unique and AOVs known.
Status resolve_channels(const RenderSettings& settings, std::span<const display::ChannelDefinition> patterns,
                        RenderJob& job) {
    std::set<std::string> names;
    if (settings.beauty) {
        display::ChannelDefinition beauty;
        beauty.name = "beauty";
        beauty.style = display::ChannelStyle::expression;
        beauty.expression = "C.*";
        beauty.space = "rendering colour space";
        beauty.statistics = !settings.splat && !job.raster;
        job.beauty = 0;
        job.channels.push_back(beauty);
        names.insert(beauty.name);
    }
    const std::size_t shift = job.channels.size();
    for (display::ChannelDefinition channel : settings.channels) {
        if (!names.insert(channel.name).second)
            return error_at({}, "the channel name '" + channel.name + "' is used twice; expected every name once");
        if (channel.style == display::ChannelStyle::name) {
            auto known = named_channel(channel.name, patterns);
            if (!known) return known.error();
            known->statistics = channel.statistics;
            channel = *std::move(known);
        }
        if (job.raster) channel.statistics = false;  // nothing to keep, but for what layers ask of it
        for (std::size_t& index : channel.rest_of) index += shift;
        job.channels.push_back(std::move(channel));
    }
    if (job.channels.empty()) return error_at({}, "nothing to render: no beauty and no channel; expected at least one");
    return display::apply_rules(settings.rules, job.beauty, job.channels);
}

/// After resolve_channels: filters may add channels that they fill.
Status make_sample_filters(const RenderSettings& settings, RenderJob& job) {
    for (const SceneEntity& entity : settings.sample_filters) {
        ParameterSet parameters = entity.parameters;
        if (parameters.location.file.empty()) parameters.location = entity.location;
        std::vector<display::ChannelDefinition> added;
        const auto add = [&](display::ChannelDefinition channel) -> Result<display::ChannelId> {
            for (const auto* list : {&job.channels, &added})
                for (const display::ChannelDefinition& known : *list)
                    if (known.name == channel.name)
                        return error_at(parameters.location, "sample filter '" + entity.type + "' adds the channel '" +
                                                                 channel.name +
                                                                 "', whose name is taken; expected another");
            added.push_back(std::move(channel));
            return static_cast<display::ChannelId>(job.channels.size() + added.size() - 1);
        };
        auto made = display::make_sample_filter(entity.type, parameters, {job.channels, job.beauty, add});
        if (!made) return made.error();
        job.sample_filters.add(*std::move(made));
        job.channels.insert(job.channels.end(), added.begin(), added.end());
    }
    return success();
}

/// The metric's channels keep statistics; after resolve_channels.
Status resolve_adaptive(const RenderSettings& settings, const ChosenIntegrator& chosen, RenderJob& job,
                        std::vector<Error>& warnings) {
    if (!settings.adaptive) return success();
    const display::AdaptiveSettings& adaptive = *settings.adaptive;
    if (settings.splat)
        return error_at(adaptive.location,
                        "adaptive sampling in filter mode splat: samples are shared by neighbouring pixels, whose "
                        "errors they cannot tell",
                        "leave out --until-error and [adaptive], or choose filter mode importance");
    if (Status s = display::AdaptiveSampler::check(adaptive, job.channels, job.beauty); !s) return s;
    if (job.raster && !chosen.integrator->traits().pixel_samples)
        return error_at(adaptive.location,
                        "light paths of integrator '" + chosen.name +
                            "' land anywhere on the image, so it "
                            "cannot sample adaptively",
                        "leave out --until-error and [adaptive], or choose another integrator, such as path");
    if (chosen.integrator->synchronous())
        return error_at(adaptive.location,
                        "integrator '" + chosen.name +
                            "' samples the whole image at once, so it cannot "
                            "sample adaptively",
                        "leave out --until-error and [adaptive], or choose another integrator, such as path");
    for (display::ChannelDefinition& channel : job.channels)
        for (const display::AdaptiveChannel& each : adaptive.channels)
            if (each.name == channel.name) channel.statistics = true;
    if (adaptive.channels.empty() && job.beauty >= 0) job.channels[static_cast<std::size_t>(job.beauty)].statistics = true;
    job.samples_per_pixel = adaptive.max_samples;
    if (job.raster)
        warnings.push_back(error_at(adaptive.location, "adaptive sampling with integrator '" + chosen.name +
                                                           "' goes by the light that camera samples bring: what light "
                                                           "paths splat (t = 1) is in the image and not in its error"));
    return success();
}

/// After resolve_sampler and resolve_adaptive.
Status resolve_limit(const RenderSettings& settings, RenderJob& job) {
    job.first_sample = settings.first_sample;
    if (settings.first_sample % RenderLoop::block_size != 0 || settings.first_sample >= job.samples_per_pixel)
        return error_at({}, "a shard that begins with sample " + std::to_string(settings.first_sample) +
                                "; expected a multiple of " + std::to_string(RenderLoop::block_size) + " below " +
                                std::to_string(job.samples_per_pixel));
    if ((settings.limit || settings.first_sample > 0) && settings.adaptive)
        return error_at(settings.adaptive->location,
                        "adaptive sampling in a render that ends by itself or is a shard: pixels "
                        "do not have the same number of samples",
                        "leave out [adaptive]");
    if (job.first_sample > 0 && job.integrator->starts_up())
        return error_at(
            {},
            "a shard of a render by Markov chains: those of every shard would begin alike, so shards are no parts "
            "of one render",
            "render with other seeds instead, or choose another integrator, such as path");
    if (!settings.limit) return success();
    const bool tells_error = job.beauty >= 0 && job.channels[static_cast<std::size_t>(job.beauty)].statistics;
    if (settings.limit->error > 0 && !tells_error)
        return error_at(
            {},
            "an end by error of a render that cannot tell it: there is no beauty, or neighbouring pixels share "
            "samples, as in filter mode splat and with integrators whose light paths land anywhere",
            "expected an end by samples or time");
    job.limit = &*settings.limit;
    if (!settings.samples_per_pixel) job.samples_per_pixel = most_limited_samples;
    return success();
}

/// Which pixels get samples. What looks at other pixels than its own is refused with a crop, by name: the bits would
/// differ from those of the whole image.
Status resolve_crop(const RenderSettings& settings, const ChosenIntegrator& chosen, RenderJob& job) {
    const int width = job.film.width, height = job.film.height;
    job.region = {-job.padding_x, -job.padding_y, width + job.padding_x, height + job.padding_y};
    if (!settings.crop) return success();
    const display::PixelRegion& crop = *settings.crop;
    if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > width || crop.y1 > height || crop.x0 >= crop.x1 || crop.y0 >= crop.y1)
        return error_at({}, "the crop " + std::to_string(crop.x0) + "," + std::to_string(crop.y0) + "," +
                                std::to_string(crop.x1) + "," + std::to_string(crop.y1) +
                                " is no part of an image of " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels; expected X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1 inside it");
    const std::string with = "a crop of a render ";
    if (job.splat)
        return error_at({}, with + "in filter mode splat, where pixels share samples; expected filter mode importance");
    if (job.raster)
        return error_at({}, with + "by integrator '" + chosen.name + "', whose light paths land anywhere on the image",
                        "leave out the crop, or choose another integrator, such as path");
    if (chosen.integrator->synchronous())
        return error_at({}, with + "by integrator '" + chosen.name + "', which learns from all pixels",
                        "leave out the crop, or choose another integrator, such as path");
    if (settings.adaptive || (settings.limit && settings.limit->error > 0))
        return error_at(settings.adaptive ? settings.adaptive->location : SourceLocation{},
                        with + "that goes on until an error: which samples a pixel gets depends on the whole image",
                        "expected a number of samples, or a time");
    job.region = crop;
    return success();
}

/// Channels that the integrator cannot fill are refused before a ray is traced.
Status check_traits(const ChosenIntegrator& chosen, const SceneView& scene, const RenderJob& job) {
    const IntegratorTraits traits = chosen.integrator->traits();
    const auto refuse = [&](display::ChannelId id, const std::string& lacks, const std::string& hint) {
        const display::ChannelDefinition& channel = job.channels[static_cast<std::size_t>(id)];
        return error_at(display::location_of(channel),
                        "channel '" + channel.name + "' (" + channel.expression + ") cannot be filled: integrator '" +
                            chosen.name + "' " + lacks,
                        hint);
    };
    if (job.lpe->needs_light_samples() >= 0 && !traits.light_samples)
        return refuse(job.lpe->needs_light_samples(), "samples no lights, so it does not know what shadows take",
                      "leave out 'unoccluded;' and 'shadows;', or choose a strategy that samples lights, such as mis");
    if (job.lpe->needs_emitter_samples() >= 0 && !traits.emitter_samples)
        return refuse(job.lpe->needs_emitter_samples(), "does not report emitters apart from the path's throughput",
                      "leave out 'nothruput;'");
    if (scene.geometry->has_holdouts() && !traits.holdouts)
        return error_at({}, "the scene has holdouts, which integrator '" + chosen.name + "' does not know",
                        "leave them out, or choose another integrator");
    if (scene.media->any() && !traits.media)
        return error_at({}, "the scene has participating media, which integrator '" + chosen.name + "' does not know",
                        "leave them out, or choose another integrator, such as path");
    return success();
}

/// After resolve_filter. What splat mode cannot do is named before anything is rendered.
Status check_splat(const RenderSettings& settings, const SourceLocation& filter, RenderJob& job) {
    if (!settings.splat) return success();
    job.splat = true;
    job.padding_x = display::splat_reach(job.filter->radius_x());
    job.padding_y = display::splat_reach(job.filter->radius_y());
    const std::string hint = "expected filter mode importance";
    if (std::max(job.padding_x, job.padding_y) > RenderLoop::tile_size)
        return error_at(filter, "pixel filter '" + job.filter->name() + "' reaches farther than " +
                                    std::to_string(RenderLoop::tile_size) + " pixels, too far for filter mode splat; " +
                                    hint);
    if (!settings.statistics.empty())
        return error_at(
            settings.statistics.front().location,
            "statistics of '" + settings.statistics.front().channel +
                "' in filter mode splat: samples are shared by neighbouring pixels, whose errors they cannot tell; " +
                hint);
    for (const display::ChannelDefinition& channel : settings.channels)
        if (channel.statistics)
            return error_at(
                display::location_of(channel),
                "channel '" + channel.name + "' keeps statistics, which filter mode splat has none of; " + hint);
    if (!settings.cryptomatte.empty())
        return error_at({},
                        "cryptomatte in filter mode splat: coverage is of samples that belong to one pixel; " + hint);
    return success();
}

/// What needs samples that belong to a pixel is refused for light that lands anywhere. After the channels are resolved.
Status check_raster(const RenderSettings& settings, const ChosenIntegrator& chosen, const SourceLocation& filter,
                    const RenderJob& job, std::vector<Error>& warnings) {
    if (!job.raster) return success();
    const std::string who = "integrator '" + chosen.name + "', whose light paths land anywhere on the image, ";
    const std::string hint = "or choose another integrator, such as path";
    if (std::max(job.filter->radius_x(), job.filter->radius_y()) + 1 > static_cast<float>(RenderLoop::tile_size))
        return error_at(filter,
                        "pixel filter '" + job.filter->name() + "' reaches farther than " +
                            std::to_string(RenderLoop::tile_size - 1) + " pixels, too far for " + who + "to splat",
                        "choose a smaller one, " + hint);
    const bool some_are_its_own = chosen.integrator->traits().pixel_samples;
    for (const display::StatisticRequest& request : settings.statistics) {
        const bool halves = request.statistic == display::Statistic::even || request.statistic == display::Statistic::odd;
        if (some_are_its_own && !halves)
            warnings.push_back(error_at(request.location,
                                        "the statistics of '" + request.channel + "' are of the light that camera samples "
                                        "bring: what integrator '" + chosen.name + "' splats (t = 1) is not in them"));
        else if (some_are_its_own)
            return error_at(request.location,
                            who + "has no halves of '" + request.channel + "': splats belong to no sample of a pixel",
                            "leave them out, " + hint);
        else
            return error_at(request.location,
                            who + "has no statistics of '" + request.channel +
                                "': a pixel's samples are not its own and cannot tell its error",
                            "leave them out, " + hint);
    }
    if (!settings.sample_filters.empty())
        return error_at(settings.sample_filters.front().location,
                        who + "takes no sample filters ('" + settings.sample_filters.front().type +
                            "'): they change the samples of camera rays",
                        "leave them out, " + hint);
    for (const display::ChannelDefinition& channel : job.channels) {
        const display::ChannelDefinition& source =
            display::takes_samples(channel) ? channel : job.channels[static_cast<std::size_t>(channel.source)];
        if (source.style == display::ChannelStyle::expression && channel.rule != display::FilterRule::filter)
            return error_at(display::location_of(channel),
                            who + "knows no rule but the pixel filter; channel '" + channel.name + "' has another",
                            "leave it out, " + hint);
    }
    return success();
}

/// After resolve_filter.
Status check_cryptomatte(const RenderSettings& settings, const SourceLocation& filter, const RenderJob& job) {
    if (settings.cryptomatte.empty()) return success();
    if (job.filter->has_negative_lobes())
        return error_at(filter, "pixel filter '" + job.filter->name() +
                                    "' has negative lobes, and coverage in a cryptomatte cannot be negative; expected "
                                    "box, triangle, gaussian or blackman-harris");
    const int ranks = settings.cryptomatte_ranks;
    if (ranks < 2 || ranks > geoaovs::Cryptomatte::most_ranks || ranks % 2 != 0)
        return error_at({}, std::to_string(ranks) + " cryptomatte ranks; expected an even number from 2 to " +
                                std::to_string(geoaovs::Cryptomatte::most_ranks));
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
    if (settings.only) {
        const SampleChoice& only = *settings.only;
        if (only.x < -job.padding_x || only.y < -job.padding_y || only.x >= job.film.width + job.padding_x ||
            only.y >= job.film.height + job.padding_y)
            return error_at({}, "pixel (" + std::to_string(only.x) + ", " + std::to_string(only.y) +
                                    ") is not in the image; expected x below " + std::to_string(job.film.width) +
                                    " and y below " + std::to_string(job.film.height));
        if (only.sample >= job.samples_per_pixel)
            return error_at({}, "sample " + std::to_string(only.sample) + " is not in the image; expected one below " +
                                    std::to_string(job.samples_per_pixel));
        job.only = only;
    }
    name = choice->name;
    return success();
}

}  // namespace

Result<display::ChannelDefinition> named_channel(const std::string& name,
                                                 std::span<const display::ChannelDefinition> patterns) {
    std::vector<std::string> names;
    for (const display::ChannelDefinition& pattern : patterns) {
        if (pattern.name == name) return pattern;
        names.push_back(pattern.name);
    }
    auto standard = geoaovs::channel_definition(name);
    if (standard) return standard;
    Error error = standard.error();
    if (const std::string near = nearest_name(name, names); !near.empty())
        error.hint = "did you mean '" + near + "', which a tee texture of the scene writes to?";
    return error;
}

Result<ResolvedRender> resolve_render(const BuiltScene& scene, const RenderSettings& settings,
                                      std::vector<Error>& warnings) {
    RenderJob job;
    auto film = read_film(scene.film, settings.resolution, warnings);
    if (!film) return film.error();
    job.film = *film;
    auto camera = PerspectiveCamera::build(scene.camera, scene.camera_to_world, film->width, film->height, warnings);
    if (!camera) return camera.error();
    job.camera = std::make_unique<PerspectiveCamera>(*std::move(camera));
    std::string sampler_name;
    const SceneEntity& filter = settings.filter ? *settings.filter : scene.filter;
    if (Status s = resolve_filter(filter, job, warnings); !s) return s.error();
    if (Status s = check_splat(settings, filter.location, job); !s) return s.error();
    if (Status s = check_cryptomatte(settings, filter.location, job); !s) return s.error();
    const SceneEntity& sampler = settings.sampler ? *settings.sampler : scene.sampler;
    if (Status s = resolve_sampler(sampler, settings, job, sampler_name, warnings); !s) return s.error();
    auto chosen = choose_integrator(integrator_for(settings.integrator, scene.integrator), settings.max_depth);
    if (!chosen) return chosen.error();
    warnings.insert(warnings.end(), chosen->warnings.begin(), chosen->warnings.end());
    job.integrator = chosen->integrator.get();
    job.raster = job.integrator->traits().raster_splats;
    if (job.only && job.integrator->starts_up())
        return error_at(
            {}, "integrator '" + chosen->name + "' cannot render one sample alone: its paths follow from one another",
            "leave out --replay, or choose another integrator, such as path");
    if (Status s = resolve_channels(settings, scene.pattern_channels(), job); !s) return s.error();
    if (Status s = make_sample_filters(settings, job); !s) return s.error();
    if (Status s = display::add_layers(settings.layers, job.channels); !s) return s.error();
    if (Status s = display::add_statistics(settings.statistics, job.channels); !s) return s.error();
    if (Status s = check_raster(settings, *chosen, filter.location, job, warnings); !s) return s.error();
    if (Status s = resolve_adaptive(settings, *chosen, job, warnings); !s) return s.error();
    if (Status s = resolve_limit(settings, job); !s) return s.error();
    if (Status s = resolve_crop(settings, *chosen, job); !s) return s.error();
    auto lpe = display::LpeSetup::build(job.channels, job.beauty);
    if (!lpe) return lpe.error();
    job.lpe = std::make_unique<display::LpeSetup>(*std::move(lpe));
    if (Status s = check_traits(*chosen, scene.view(), job); !s) return s.error();
    if (settings.picked_lobes) job.attribution = display::LpeServices::Attribution::picked;
    job.threads =
        settings.threads > 0 ? settings.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    job.has_extra_rows = scene.view().geometry->has_alpha() || scene.view().media->any();
    return ResolvedRender{std::move(job), *std::move(chosen), std::move(sampler_name)};
}

}  // namespace raylex::transport
