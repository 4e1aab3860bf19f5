// The response of a film to light, by pbrt-v4's sensors: exposure and white balance.
#pragma once

#include <vector>

#include "transport/color/color_space.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct FilmSensor {
    Matrix3 recorded;  ///< from linear RGB of light in the scene to the film's recording of it
    /// From the recording to the values that pbrt-v4 compares with "maxcomponentvalue": XYZ before white balance. For a
    /// camera's sensor: its own RGB, in which green is usually the largest and close to Y.
    Matrix3 measured;
};

/// Reads the response of a scene's film to light in `space`. The factor is exposure time x iso / 100 for every sensor
/// (pbrt-v4 format); the time is the camera's shutterclose - shutteropen, or the film's "exposuretime". "whitebalance"
/// takes the white of CIE daylight of that temperature (below 4000 K of a blackbody) to the space's own white by
/// Bradford's cone responses (K. M. Lam 1985). 0 means none, or 6500 K for sensors named after cameras, as in pbrt.
/// camera_sensors.h contains those; they add a warning. Errors: no exposure, an unknown sensor. The parameters are
/// marked as used.
Result<FilmSensor> read_sensor(const SceneEntity& film, const SceneEntity& camera, ColorSpace space,
                               std::vector<Error>& warnings);

}  // namespace raylex::transport
