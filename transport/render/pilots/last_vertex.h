// Chooses how often the last vertex of a path uses each of its two techniques.
#pragma once

#include "transport/integrators/integrator.h"
#include "transport/paths/subpaths/live_lights.h"

namespace raylex::transport {

/// Chooses the shares with the least product of cost (rays) and mean relative variance, for paths whose first vertex
/// only a light can follow (Law 4). Both techniques cost a ray, and often one of them finds nearly all of the light. A
/// pilot of a few thousand paths of one scattering compares a fixed set of shares by the same samples. The variance of
/// each is two integrals over directions (Veach 1997, section 9.2, with fractional numbers of samples), which the
/// samples of both techniques estimate together. Cutouts and media on the way attenuate as they do for paths; events of
/// cutouts are ignored. Returns {1, 1} if other shares do not save 5 %, if more than a light can follow some vertex, or
/// if media emit, are inside bodies, or scatter for some channel. Adds the rays that it traces to `rays`.
TechniqueShares choose_techniques(const IntegratorContext& context, const LiveLights& lights, std::uint64_t& rays);

}  // namespace raylex::transport
