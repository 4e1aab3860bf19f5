// Closures by name, for probes of scattering.
#pragma once

#include "experiments/stability/probe.h"
#include "transport/materials/closures/closure.h"

namespace raylex::experiments {

/// A closure, and what its probes must know of it.
struct ProbedBsdf {
    transport::Bsdf bsdf;
    transport::Frame frame;       ///< of its directions; not the world's
    double width = 1;             ///< of its narrowest lobe, radians
    bool about_wo = false;        ///< lobes lie about -wo, not about the mirrored direction
    transport::Real forward = 1;  ///< -1: about wo
    double eta = 0;               ///< of glass, inside over outside; 0: opaque
};

/// Word "material": lambert, conductor (reflectance 1), metal (copper-like), dielectric, thindielectric, coateddiffuse,
/// coatedconductor, additive, ideal, custom, phase. Numbers: alpha, alpha_y (= alpha), eta (1.5), reflectance (1),
/// coat_alpha (0), thickness (0.01), albedo (0, of the coat's slab), g (0), compensate (0 or 1).
Result<ProbedBsdf> probed_bsdf(const ProbeInput& input);

/// In the frame of the closure: the cosine "mu" (negative: from below), at azimuth "phi" (0.7 radians).
transport::Vec3 probed_direction(const ProbeInput& input);

}  // namespace raylex::experiments
