// How often the last vertex of a path uses each of its two techniques.
#pragma once

#include "transport/integrators/integrator.h"
#include "transport/paths/subpaths/live_lights.h"

namespace raylex::transport {

/// The shares with the least product of cost (rays) and mean relative variance, where nothing but a light can follow
/// the first vertex (Law 4), by a pilot of a few thousand paths of one scattering: both cost a ray, and often one finds
/// nearly all of the light. Each of a fixed set of shares is judged by the same samples: its variance is two integrals
/// over directions (Veach 1997, section 9.2, with fractional numbers of samples), which the samples of both techniques
/// estimate together. Cutouts and media on the way count as they do for paths, the events of cutouts apart. {1, 1}
/// where others do not save 5 %, where a vertex is met that more can follow, and where media emit, are inside bodies,
/// or scatter for some channel. The rays that it traces are added to `rays`.
TechniqueShares choose_techniques(const IntegratorContext& context, const LiveLights& lights, std::uint64_t& rays);

}  // namespace raylex::transport
