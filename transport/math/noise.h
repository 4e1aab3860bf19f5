// Gradient noise (K. Perlin 2002, "Improving Noise", Proc. SIGGRAPH) and its sums over octaves.
//
// The gradients are chosen as pbrt-v4 does, which differs from Perlin's own program in 2 of 16, so that the textures
// made of it are the same.
#pragma once

#include "transport/math/vec.h"

namespace raylex::transport {

/// In [-1, 1]; 0 at points of whole numbers. 0 for what is not finite.
[[nodiscard]] Real gradient_noise(const Vec3& p);
/// What it gains over a step along x, along y and along z, to the bit; at the cost of about two. Steps below 1.
[[nodiscard]] Vec3 noise_differences(const Vec3& p, Real step);

/// Every octave is 1.99 times as fine as the one before, and `roughness` times as high.
struct Octaves {
    int count = 8;
    Real roughness = Real(0.5);
};
/// Sum of the octaves of noise: fractional Brownian motion.
[[nodiscard]] Real noise_sum(const Vec3& p, const Octaves& octaves);
/// Sum of their absolute values: what turbulence looks like.
[[nodiscard]] Real absolute_noise_sum(const Vec3& p, const Octaves& octaves);

}  // namespace raylex::transport
