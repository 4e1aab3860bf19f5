// `bdpt`: bidirectional path tracing (Veach 1997, chapter 10). Every camera sample makes a subpath from the camera and
// one from a light, and connects every vertex of one with every vertex of the other.
//
// With s vertices from the light and t from the camera, a path is found
//     s = 0          when the camera subpath meets a light by itself;
//     s = 1          by a light sample, drawn anew for each vertex (next event estimation);
//     t = 1          when a light subpath's vertex is connected to the camera: a splat through the pixel filter;
//     s, t >= 2      by connecting two vertices;
// t = 0 is left out: no ray meets a pinhole, and hardly any a lens. Only s = 0 finds light that the camera sees
// directly. Each strategy has the weight of the power heuristic over all strategies that could have made the path
// (paths/partial_mis_weights.h).
//
// Path strings. The camera subpath's tracker goes on over the connection and back along the light subpath's events to
// its light. So every channel takes exact shares whatever found the path (Law 5).
//
// Media. Collisions are vertices like others, with a phase function for a closure and 1 for a cosine. Light subpaths
// begin in the medium around their light. Camera subpaths alone find light that media emit (s = 0).
//
// The prefixes nothruput, unoccluded and shadows apply to lights that camera subpaths meet or sample (s < 2), as with
// `path`.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

struct BdptParameters {
    DepthParameters depth;
    std::uint32_t first_depth = 0;  ///< WalkOptions::first_depth (not a parameter)
    bool count_mirrors = true;      ///< WalkOptions::counts_first_specular
    GuideRequest guide{};           ///< of camera subpaths; without make_trial
};

/// Makes the integrator for other integrators that use it.
std::unique_ptr<Integrator> make_bdpt_integrator(const BdptParameters& parameters);

/// The registry's entry: parameters maxdepth, countmirrors, roulette, rrthreshold, guide, guidesamples.
Registry<IntegratorFactory>::Entry bdpt_entry();

}  // namespace raylex::transport
