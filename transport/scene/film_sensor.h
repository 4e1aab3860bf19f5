// What a film makes of the light that reaches it, by pbrt-v4's sensors: exposure and white balance.
#pragma once

#include <vector>

#include "transport/color/color_space.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct FilmSensor {
    Matrix3 recorded;  ///< from linear RGB of light in the scene to what the film records of it
    /// From what it records to what pbrt-v4 compares with "maxcomponentvalue": XYZ before white balance; of a camera's
    /// sensor its own RGB, of which green is nearly always the largest, and nearly Y.
    Matrix3 measured;
};

/// What the film of a scene makes of light in `space`. The factor is exposure time x iso / 100 for
/// every sensor (pbrt-v4 format), the time being the camera's shutterclose - shutteropen, or the film's "exposuretime".
/// "whitebalance" takes the white of CIE daylight of that temperature (below 4000 K of a blackbody) to the space's own
/// white by Bradford's cone responses (K. M. Lam 1985); 0 is none, or 6500 K for sensors named after cameras, pbrt's
/// default for them. Those are camera_sensors.h's, with a warning. Errors: no exposure, a sensor that nobody knows. The
/// parameters are marked as used.
Result<FilmSensor> read_sensor(const SceneEntity& film, const SceneEntity& camera, ColorSpace space,
                               std::vector<Error>& warnings);

}  // namespace raylex::transport
