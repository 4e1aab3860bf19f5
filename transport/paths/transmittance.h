// Light through cutouts: what shadow rays and light samples make of surfaces with alpha.
#pragma once

#include "transport/paths/counters.h"
#include "transport/paths/event_table.h"

namespace raylex::transport {

/// What an emitter with a cutout keeps at the sampled point: as much as scattering finds there on average. `from` is where
/// the light goes; only its direction matters.
[[nodiscard]] float emitter_opacity(const SceneView& scene, const LightSample& sample, const Vec3& from);

struct StraightWalk {
    const SceneView& scene;
    const EventTable& events;
    display::LpeServices& lpe;
    IntegratorCounters& counters;
    bool to_the_end = false;  ///< goes on behind what lets nothing through, for the media there
};

/// What the cutouts along a shadow ray let through of `visible`, 0 behind an opaque surface; moves `tracker` past them.
/// `through` takes what the media on the way let pass, `medium` being the first (-1: none); opaque surfaces are no borders
/// to it.
float straight_transmittance(const StraightWalk& walk, Ray ray, float visible, std::int32_t medium,
                             display::Tracker& tracker, Rgb& through);

}  // namespace raylex::transport
