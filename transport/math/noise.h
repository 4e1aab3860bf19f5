// Gradient noise (K. Perlin 2002, "Improving Noise", Proc. SIGGRAPH) and its sums over octaves.
//
// The choice of gradients is pbrt-v4's, which differs from Perlin's own program in 2 of 16, so that textures are the
// same.
#pragma once

#include "transport/math/vec.h"

namespace raylex::transport {

/// Gradient noise in [-1, 1]; 0 at integer points, and for arguments that are not finite.
[[nodiscard]] Real gradient_noise(const Vec3& p);
/// The differences of gradient_noise() over a step along x, along y and along z, with the same bits, at the cost of
/// about two evaluations. Steps are below 1.
[[nodiscard]] Vec3 noise_differences(const Vec3& p, Real step);

/// Each octave has 1.99 times the frequency of the previous one and `roughness` times its height.
struct Octaves {
    int count = 8;
    Real roughness = Real(0.5);
};
/// Sum of the octaves of noise: fractional Brownian motion.
[[nodiscard]] Real noise_sum(const Vec3& p, const Octaves& octaves);
/// Sum of the absolute values of the octaves: turbulence.
[[nodiscard]] Real absolute_noise_sum(const Vec3& p, const Octaves& octaves);

}  // namespace raylex::transport
