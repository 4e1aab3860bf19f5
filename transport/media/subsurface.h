// Computes the medium under a translucent surface from a diffuse reflectance, as pbrt-v4's subsurface material does, so
// that scene files give the same material.
#pragma once

#include "transport/math/real.h"

namespace raylex::transport {

/// Single-scattering albedo, sigma_s / sigma_t, in [0, 1] for each colour, of a half space of refractive index `eta`
/// and asymmetry `g` that reflects the share `reflectance` of the light that has entered it, by photon beam diffusion
/// (Habel et al. 2013, "Photon Beam Diffusion: A Hybrid Monte Carlo Method for Subsurface Scattering"; pbrt book, 4th
/// edition, after Christensen and Burley). It takes a third of a second, at load.
Rgb scattering_albedo_of_reflectance(const Rgb& reflectance, double eta, double g);

}  // namespace raylex::transport
