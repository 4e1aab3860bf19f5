// Decides how many samples a render takes, which ones, and of which pixels.
#include "transport/render/resolve/limited_passes.h"
#include "transport/render/resolve/resolve_checks.h"

namespace raylex::transport {
namespace {

/// Without a beauty and without metric channels, the metric uses all requested light (Law 4).
display::AdaptiveSettings with_metric(display::AdaptiveSettings adaptive, const JobChannels& channels) {
    if (!adaptive.channels.empty() || channels.beauty >= 0) return adaptive;
    for (const display::ChannelDefinition& channel : channels.list)
        if (channel.style == display::ChannelStyle::expression && channel.rule == display::FilterRule::filter &&
            display::takes_samples(channel))
            adaptive.channels.push_back({channel.name, 1, adaptive.location});
    return adaptive;
}

/// Makes the channels of the metric keep statistics.
Status resolve_adaptive(const StopSettings& stop, bool splat, const ChosenIntegrator& chosen, JobChannels& channels,
                        Budget& budget, std::vector<Error>& warnings) {
    if (!stop.adaptive) return success();
    const display::AdaptiveSettings adaptive = with_metric(*stop.adaptive, channels);
    if (splat)
        return error_at(adaptive.location,
                        "adaptive sampling in filter mode splat: samples are shared by neighbouring pixels, whose "
                        "errors cannot be estimated",
                        "leave out --until-error and [adaptive], or choose filter mode importance");
    if (Status s = display::AdaptiveSampler::check(adaptive, channels.list, channels.beauty); !s) return s;
    if (ResolvedJob::splats_anywhere(chosen) && !chosen.integrator->traits().pixel_samples)
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
    for (display::ChannelDefinition& channel : channels.list)
        for (const display::AdaptiveChannel& each : adaptive.channels)
            if (each.name == channel.name) channel.statistics = true;
    if (adaptive.channels.empty() && channels.beauty >= 0)
        channels.list[static_cast<std::size_t>(channels.beauty)].statistics = true;
    budget.adaptive = adaptive;
    budget.samples_per_pixel = adaptive.max_samples;
    if (ResolvedJob::splats_anywhere(chosen))
        warnings.push_back(
            error_at(adaptive.location, "adaptive sampling with integrator '" + chosen.name +
                                            "' measures the error of camera samples only: light that light "
                                            "paths splat (t = 1) is in the image but not in its error"));
    return success();
}

/// Resolves the samples of a pixel if their number is not known in advance or not all are requested.
Status resolve_limit(const SampleSettings& samples, const StopSettings& stop, const ChosenIntegrator& chosen,
                     const JobChannels& channels, Budget& budget) {
    budget.first_sample = samples.first;
    if (samples.first % TileGrid::block_size != 0 || samples.first >= budget.samples_per_pixel)
        return error_at({}, "a shard that begins with sample " + std::to_string(samples.first) +
                                "; expected a multiple of " + std::to_string(TileGrid::block_size) + " below " +
                                std::to_string(budget.samples_per_pixel));
    if ((stop.limit || samples.first > 0) && stop.adaptive)
        return error_at(stop.adaptive->location,
                        "adaptive sampling in a render with a time or error limit, or in a shard: pixels "
                        "do not have the same number of samples",
                        "leave out [adaptive]");
    if (budget.first_sample > 0 && chosen.integrator->starts_up())
        return error_at(
            {},
            "a shard of a render by Markov chains: the chains of all shards would begin alike, so shards are not parts "
            "of one render",
            "render with other seeds instead, or choose another integrator, such as path");
    if (!stop.limit) return success();
    const bool tells_error =
        channels.beauty >= 0 && channels.list[static_cast<std::size_t>(channels.beauty)].statistics;
    if (stop.limit->error > 0 && !tells_error)
        return error_at({},
                        "an error limit in a render whose error cannot be estimated: there is no beauty, or "
                        "neighbouring pixels share "
                        "samples, as in filter mode splat and with integrators whose light paths land anywhere",
                        "expected a number of samples or a time limit");
    budget.limit = stop.limit;
    if (!samples.per_pixel) budget.samples_per_pixel = most_limited_samples;
    return success();
}

/// Resolves one single sample, which may be any in the budget.
Status resolve_only(const SampleSettings& samples, const CameraSampling& sampling, const ChosenIntegrator& chosen,
                    Budget& budget) {
    if (!samples.only) return success();
    if (chosen.integrator->starts_up())
        return error_at(
            {}, "integrator '" + chosen.name + "' cannot render a single sample: its paths depend on one another",
            "leave out --replay, or choose another integrator, such as path");
    const SampleChoice& only = *samples.only;
    if (only.x < -sampling.padding_x || only.y < -sampling.padding_y ||
        only.x >= sampling.film.width + sampling.padding_x || only.y >= sampling.film.height + sampling.padding_y)
        return error_at({}, "pixel (" + std::to_string(only.x) + ", " + std::to_string(only.y) +
                                ") is not in the image; expected x below " + std::to_string(sampling.film.width) +
                                " and y below " + std::to_string(sampling.film.height));
    if (only.sample >= budget.samples_per_pixel)
        return error_at({}, "sample " + std::to_string(only.sample) + " is not in the image; expected one below " +
                                std::to_string(budget.samples_per_pixel));
    budget.only = only;
    return success();
}

}  // namespace

Result<Budget> resolve_budget(const SampleSettings& samples, const StopSettings& stop, const CameraSampling& sampling,
                              const ChosenIntegrator& chosen, JobChannels& channels, std::vector<Error>& warnings) {
    Budget budget;
    budget.samples_per_pixel = sampling.samples_per_pixel;
    if (Status s = resolve_adaptive(stop, sampling.splat, chosen, channels, budget, warnings); !s) return s.error();
    if (Status s = resolve_limit(samples, stop, chosen, channels, budget); !s) return s.error();
    if (Status s = resolve_only(samples, sampling, chosen, budget); !s) return s.error();
    const bool known = !budget.limit || (samples.per_pixel && !(budget.limit->seconds > 0));
    // A render that only its error ends may end after few samples: its guide costs no more than that of a short render.
    const bool timed = budget.limit && budget.limit->seconds > 0;
    budget.whole = samples.whole.value_or(known ? budget.samples_per_pixel : timed ? 0 : least_for_error);
    return budget;
}

/// Refuses features that read other pixels than their own.
Status check_pixels_independent(const StopSettings& stop, bool splat, const ChosenIntegrator& chosen,
                                const std::string& what, const std::string& without) {
    const std::string hint = "leave out " + without + ", or choose another integrator, such as path";
    if (splat)
        return error_at({},
                        what + " in filter mode splat, where pixels share samples; expected filter mode importance");
    if (ResolvedJob::splats_anywhere(chosen))
        return error_at({}, what + " by integrator '" + chosen.name + "', whose light paths land anywhere on the image",
                        hint);
    if (chosen.integrator->synchronous())
        return error_at({}, what + " by integrator '" + chosen.name + "', which learns from all pixels", hint);
    if (stop.adaptive || (stop.limit && stop.limit->error > 0))
        return error_at(stop.adaptive ? stop.adaptive->location : SourceLocation{},
                        what + " with an error limit: the samples of a pixel depend on the whole image",
                        "expected a number of samples, or a time");
    return success();
}

/// Selects the pixels that get samples. With a crop, features that read other pixels are refused by name, since the
/// bits would differ from those of the whole image.
Result<TileGrid> resolve_grid(const StopSettings& stop, const CameraSampling& sampling,
                              const ChosenIntegrator& chosen) {
    const int width = sampling.film.width, height = sampling.film.height;
    const int px = sampling.padding_x, py = sampling.padding_y;
    TileGrid grid{width, height, px, py, {-px, -py, width + px, height + py}};
    if (!sampling.film.crop) return grid;
    const display::PixelRegion& crop = *sampling.film.crop;
    if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > width || crop.y1 > height || crop.x0 >= crop.x1 || crop.y0 >= crop.y1)
        return error_at(
            {}, "the crop " + std::to_string(crop.x0) + "," + std::to_string(crop.y0) + "," + std::to_string(crop.x1) +
                    "," + std::to_string(crop.y1) + " is not inside the image of " + std::to_string(width) + " x " +
                    std::to_string(height) + " pixels; expected X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1 inside it");
    if (Status s = check_pixels_independent(stop, sampling.splat, chosen, "a crop of a render", "the crop"); !s)
        return s.error();
    grid.region = crop;
    return grid;
}

}  // namespace raylex::transport
