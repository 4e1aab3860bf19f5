// The steps of ResolvedJob::resolve(), each of which uses the results of the previous ones. Private to
// transport/render.
#pragma once

#include "transport/render/resolve/resolved_job.h"

namespace raylex::transport {

/// Resolves the channels, without LPE services, since budgets may still add statistics. `patterns` are the scene's
/// pattern channels.
Result<JobChannels> resolve_channels(const ChannelSettings& settings, const LabelSettings& labels,
                                     std::span<const display::ChannelDefinition> patterns,
                                     const ChosenIntegrator& chosen, bool splat);

/// Refuses cameras whose rays have weights, with integrators that do not support them.
Status check_camera(const ChosenIntegrator& chosen, const SceneEntity& entity, const Camera& camera);

/// Refuses features that need samples of a single pixel, for integrators that splat anywhere.
Status check_raster(const ChannelSettings& settings, const ChosenIntegrator& chosen, const CameraSampling& sampling,
                    const JobChannels& channels, std::vector<Error>& warnings);

/// Resolves the budget. Channels of an adaptive metric keep statistics afterwards.
Result<Budget> resolve_budget(const SampleSettings& samples, const StopSettings& stop, const CameraSampling& sampling,
                              const ChosenIntegrator& chosen, JobChannels& channels, std::vector<Error>& warnings);

/// Refuses features that read other pixels than their own: `what` ("a crop of a render") names the purpose, and
/// `without` the option to leave out.
Status check_pixels_independent(const StopSettings& stop, bool splat, const ChosenIntegrator& chosen,
                                const std::string& what, const std::string& without);

/// Selects the pixels that get samples. With a crop, features that read other pixels are refused by name, since the
/// bits would differ from those of the whole image.
Result<TileGrid> resolve_grid(const StopSettings& stop, const CameraSampling& sampling, const ChosenIntegrator& chosen);

/// Refuses channels that the integrator cannot fill.
Status check_traits(const ChosenIntegrator& chosen, const SceneView& scene, const JobChannels& channels);

}  // namespace raylex::transport
