// The steps of ResolvedJob::resolve(), each of which takes what the ones before it made: private to transport/render.
#pragma once

#include "transport/render/resolve/resolved_job.h"

namespace raylex::transport {

/// Without LPE services: budgets may yet ask channels for statistics. `patterns` are the scene's pattern channels.
Result<JobChannels> resolve_channels(const ChannelSettings& settings, const LabelSettings& labels,
                                     std::span<const display::ChannelDefinition> patterns,
                                     const ChosenIntegrator& chosen, bool splat);

/// Cameras whose rays count differently are refused with integrators that do not know that.
Status check_camera(const ChosenIntegrator& chosen, const SceneEntity& entity, const Camera& camera);

/// What needs samples that belong to a pixel is refused for light that lands anywhere.
Status check_raster(const ChannelSettings& settings, const ChosenIntegrator& chosen, const CameraSampling& sampling,
                    const JobChannels& channels, std::vector<Error>& warnings);

/// Channels that an adaptive budget goes by keep statistics from now on.
Result<Budget> resolve_budget(const SampleSettings& samples, const StopSettings& stop, const CameraSampling& sampling,
                              const ChosenIntegrator& chosen, JobChannels& channels, std::vector<Error>& warnings);

/// Refuses what looks at other pixels than its own: `what` ("a crop of a render"), which one can do `without`, by name.
Status check_pixels_apart(const StopSettings& stop, bool splat, const ChosenIntegrator& chosen, const std::string& what,
                          const std::string& without);

/// Which pixels get samples. What looks at other pixels than its own is refused with a crop, by name: the bits would
/// differ from those of the whole image.
Result<TileGrid> resolve_grid(const StopSettings& stop, const CameraSampling& sampling, const ChosenIntegrator& chosen);

/// Channels that the integrator cannot fill are refused before a ray is traced.
Status check_traits(const ChosenIntegrator& chosen, const SceneView& scene, const JobChannels& channels);

}  // namespace raylex::transport
