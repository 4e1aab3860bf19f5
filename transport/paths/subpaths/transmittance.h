// What shadow rays and light samples find in the way: cutouts and media.
#pragma once

#include "transport/paths/counters.h"
#include "transport/paths/record.h"

namespace raylex::transport {

/// What an emitter with a cutout keeps at the sampled point: as much as scattering finds there on average. `from` is
/// where the light goes; only its direction matters.
[[nodiscard]] Real emitter_opacity(const SceneView& scene, const LightSample& sample, const Vec3& from);

struct StraightWalk {
    const SceneView& scene;
    const Record& record;
    IntegratorCounters& counters;
    bool to_the_end = false;  ///< goes on behind what lets nothing through, for the media there
    /// For what is met by chance in grids: a key of the ray's own; no matter where there are none.
    FlightNumbers numbers{0};
};

/// What the cutouts along a shadow ray let through of `visible`, 0 behind an opaque surface; moves `tracker` past them.
/// `through` takes what the media on the way let pass, `medium` being the first (-1: none); opaque surfaces are no
/// borders to it.
Real straight_transmittance(const StraightWalk& walk, Ray ray, Real visible, std::int32_t medium,
                            display::Tracker& tracker, Rgb& through);

/// The medium at `point`, found by going there from `camera` past all surfaces, cutouts and opaque ones alike: where a
/// light without an interface of its own stands. Right where a scene's interfaces are closed, as free flights take them
/// to be.
[[nodiscard]] std::int32_t medium_at(const SceneView& scene, const Vec3& camera, const Vec3& point);
/// The same infinitely far away in `direction`.
[[nodiscard]] std::int32_t medium_far_away(const SceneView& scene, const Vec3& camera, const Vec3& direction);

/// [light] The medium that light flies through when it leaves; of a light whose shape is a border between media the one
/// that it stands in otherwise. Empty without media.
[[nodiscard]] std::vector<std::int32_t> media_of_lights(const SceneView& scene, const Vec3& camera);

}  // namespace raylex::transport
