// Refuses by name, before a ray is traced, what cannot be rendered.
#include "transport/render/resolve/resolve_checks.h"

#include <algorithm>

namespace raylex::transport {

/// Refuses channels that the integrator cannot fill.
Status check_traits(const ChosenIntegrator& chosen, const SceneView& scene, const JobChannels& channels) {
    const IntegratorTraits traits = chosen.integrator->traits();
    const auto refuse = [&](display::ChannelId id, const std::string& lacks, const std::string& hint) {
        const display::ChannelDefinition& channel = channels.list[static_cast<std::size_t>(id)];
        return error_at(display::location_of(channel),
                        "channel '" + channel.name + "' (" + channel.expression + ") cannot be filled: integrator '" +
                            chosen.name + "' " + lacks,
                        hint);
    };
    if (channels.lpe->needs_light_samples() >= 0 && !traits.light_samples)
        return refuse(channels.lpe->needs_light_samples(), "samples no lights, so it cannot compute shadows",
                      "leave out 'unoccluded;' and 'shadows;', or choose a strategy that samples lights, such as mis");
    if (channels.lpe->needs_emitter_samples() >= 0 && !traits.emitter_samples)
        return refuse(channels.lpe->needs_emitter_samples(),
                      "does not report emitters apart from the path's throughput", "leave out 'nothruput;'");
    if (channels.keeps_path_strings && !traits.reports_path_strings)
        return error_at({},
                        "integrator '" + chosen.name +
                            "' supports no path atlas: it sums its splats per "
                            "channel, without their path strings",
                        "leave out the atlas, or choose another integrator, such as path or bdpt");
    if (scene.geometry->has_holdouts() && !traits.holdouts)
        return error_at({}, "the scene has holdouts, which integrator '" + chosen.name + "' does not support",
                        "leave them out, or choose another integrator");
    if (scene.media->any() && !traits.media)
        return error_at({},
                        "the scene has participating media, which integrator '" + chosen.name + "' does not support",
                        "leave them out, or choose another integrator, such as path");
    return success();
}

Status check_camera(const ChosenIntegrator& chosen, const SceneEntity& entity, const Camera& camera) {
    if (!camera.weighs_rays() || chosen.integrator->traits().camera_weights) return success();
    return error_at(entity.location,
                    "camera '" + entity.type + "' cannot be used with integrator '" + chosen.name +
                        "': light paths cannot be connected to its film, and its rays have weights",
                    "choose another integrator, such as path, or another camera");
}

/// Refuses features that need samples of a single pixel, for integrators that splat anywhere.
Status check_raster(const ChannelSettings& settings, const ChosenIntegrator& chosen, const CameraSampling& sampling,
                    const JobChannels& channels, std::vector<Error>& warnings) {
    if (!ResolvedJob::splats_anywhere(chosen)) return success();
    const std::string who = "integrator '" + chosen.name + "', whose light paths land anywhere on the image, ";
    const std::string hint = "or choose another integrator, such as path";
    if (std::max(sampling.filter->radius_x(), sampling.filter->radius_y()) + 1 >
        static_cast<float>(TileGrid::tile_size))
        return error_at(sampling.filter_location,
                        "pixel filter '" + sampling.filter->name() + "' reaches farther than " +
                            std::to_string(TileGrid::tile_size - 1) + " pixels, too far for " + who + "to splat",
                        "choose a smaller one, " + hint);
    const bool some_are_its_own = chosen.integrator->traits().pixel_samples;
    for (const display::StatisticRequest& request : settings.statistics) {
        const bool halves =
            request.statistic == display::Statistic::even || request.statistic == display::Statistic::odd;
        if (some_are_its_own && !halves)
            warnings.push_back(error_at(request.location, "the statistics of '" + request.channel +
                                                              "' contain light of camera samples "
                                                              "only: light that integrator '" +
                                                              chosen.name + "' splats (t = 1) is missing"));
        else if (some_are_its_own)
            return error_at(
                request.location,
                who + "has no halves of '" + request.channel + "': splats do not belong to samples of a pixel",
                "leave them out, " + hint);
        else
            return error_at(request.location,
                            who + "has no statistics of '" + request.channel +
                                "': other pixels' samples contribute to a pixel, so its error cannot be estimated",
                            "leave them out, " + hint);
    }
    const auto filter = std::find_if(settings.sample_filters.begin(), settings.sample_filters.end(),
                                     [](const SceneEntity& each) { return each.type != "none"; });
    if (filter != settings.sample_filters.end() && !(some_are_its_own && channels.filters.fits_splats()))
        return error_at(filter->location,
                        who + "supports no sample filters ('" + filter->type +
                            "'): filters change only the samples of camera rays" +
                            (some_are_its_own ? "; 'clamp' bounds splats as well" : ""),
                        "leave them out, " + hint);
    for (const display::ChannelDefinition& channel : channels.list) {
        const display::ChannelDefinition& source =
            display::takes_samples(channel) ? channel : channels.list[static_cast<std::size_t>(channel.source)];
        if (source.style == display::ChannelStyle::expression && channel.rule != display::FilterRule::filter)
            return error_at(display::location_of(channel),
                            who + "supports no rule but the pixel filter; channel '" + channel.name + "' has another",
                            "leave it out, " + hint);
    }
    return success();
}

}  // namespace raylex::transport
