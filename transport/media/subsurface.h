// The medium under a translucent surface, from a diffuse reflectance: what pbrt-v4's subsurface material takes its
// coefficients from, so that scene files mean the same.
#pragma once

#include "transport/math/real.h"

namespace raylex::transport {

/// Single-scattering albedo, sigma_s / sigma_t, of a half space of refractive index `eta` and asymmetry `g` that sends
/// back `reflectance` of the light that has entered it, by photon beam diffusion (Habel et al. 2013, "Photon Beam
/// Diffusion: A Hybrid Monte Carlo Method for Subsurface Scattering"; book, 4th edition of pbrt, after Christensen and
/// Burley). 0 to 1; each colour apart. A third of a second: for the time of loading.
Rgb scattering_albedo_of_reflectance(const Rgb& reflectance, double eta, double g);

}  // namespace raylex::transport
