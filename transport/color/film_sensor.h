// What a film makes of the light that reaches it, by pbrt-v4's sensors: exposure and white balance.
#pragma once

#include <vector>

#include "transport/color/color_space.h"

namespace raylex::transport {

/// From linear RGB of light in `space` to what the film records of it. The factor is exposure time x iso / 100 for
/// every sensor (pbrt-v4 format), the time being the camera's shutterclose - shutteropen, or the film's "exposuretime".
/// "whitebalance" takes the white of CIE daylight of that temperature (below 4000 K of a blackbody) to the space's own
/// white by Bradford's cone responses (K. M. Lam 1985); 0 is none. Sensors named after cameras, whose spectral
/// responses are not here, count as cie1931 balanced for 6500 K, pbrt's default for them, with a warning. Errors: no
/// exposure, a sensor that nobody knows. The parameters are marked as used.
Result<Matrix3> read_sensor(const SceneEntity& film, const SceneEntity& camera, ColorSpace space,
                            std::vector<Error>& warnings);

}  // namespace raylex::transport
