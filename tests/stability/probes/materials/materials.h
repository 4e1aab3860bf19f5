// Closures by name, for scattering probes.
#pragma once

#include "experiments/stability/probe.h"
#include "transport/materials/closures/closure.h"

namespace raylex::experiments {

/// A closure with the properties that its probes need.
struct ProbedBsdf {
    transport::Bsdf bsdf;
    transport::Frame frame;       ///< frame of its directions, different from the world's
    double width = 1;             ///< width of its narrowest lobe in radians
    bool about_wo = false;        ///< lobes are around -wo, not around the mirrored direction
    transport::Real forward = 1;  ///< -1: around wo
    double eta = 0;               ///< of glass: inside relative to outside; 0: opaque
};

/// Returns a closure for the word "material": lambert, conductor (reflectance 1), metal (copper-like), dielectric,
/// thindielectric, coateddiffuse, coatedconductor, additive, ideal, custom, phase. Numbers: alpha, alpha_y (= alpha),
/// eta (1.5), reflectance (1), coat_alpha (0), thickness (0.01), albedo (0, of the coat's slab), g (0), compensate (0
/// or 1).
Result<ProbedBsdf> probed_bsdf(const ProbeInput& input);

/// Returns a direction in the closure's frame with cosine "mu" (negative: from below) and azimuth "phi" (0.7 radians).
transport::Vec3 probed_direction(const ProbeInput& input);

}  // namespace raylex::experiments
