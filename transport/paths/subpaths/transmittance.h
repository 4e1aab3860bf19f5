// Cutouts and media in the way of shadow rays and light samples.
#pragma once

#include "transport/paths/counters.h"
#include "transport/paths/record.h"

namespace raylex::transport {

/// The opacity of an emitter with a cutout at the sampled point: the mean of what rays find there. `from`: where the
/// light goes; only its direction matters.
[[nodiscard]] Real emitter_opacity(const SceneView& scene, const LightSample& sample, const Vec3& from);

struct PassThroughRay {
    const SceneView& scene;
    const Record& record;
    IntegratorCounters& counters;
    bool to_the_end = false;   ///< goes on behind opaque surfaces, for the media there
    FlightNumbers numbers{0};  ///< for media in grids: a key of the ray's own
};

/// Returns `visible` times the transparency of the cutouts along a shadow ray, 0 behind an opaque surface, and moves
/// `tracker` past them. Multiplies `through` by the transmittance of the media on the way. `medium`: the first (-1:
/// none). Opaque surfaces are no borders between media.
Real pass_through_transmittance(const PassThroughRay& walk, Ray ray, Real visible, std::int32_t medium,
                                display::Tracker& tracker, Rgb& through);

/// The medium at `point`, found by going there from `camera` through all surfaces, opaque ones too: the medium around a
/// light that has no interface of its own. Correct where the interfaces of a scene are closed, which sampled distances
/// assume as well.
[[nodiscard]] std::int32_t medium_at(const SceneView& scene, const Vec3& camera, const Vec3& point);
/// The medium infinitely far away in `direction`.
[[nodiscard]] std::int32_t medium_far_away(const SceneView& scene, const Vec3& camera, const Vec3& direction);

/// [light] The medium that light enters when it leaves the light; -1 for a light whose shape is a border between media.
/// Empty without media.
[[nodiscard]] std::vector<std::int32_t> media_of_lights(const SceneView& scene, const Vec3& camera);

}  // namespace raylex::transport
