// The tables of probes, one for each file in this folder.
#pragma once

#include <span>

#include "experiments/stability/probe.h"

namespace raylex::experiments {

std::span<const NamedProbe> closed_mesh_probes();
std::span<const NamedProbe> elementary_probes();
std::span<const NamedProbe> enclosure_probes();
std::span<const NamedProbe> facet_probes();
std::span<const NamedProbe> file_probes();
std::span<const NamedProbe> geometry_probes();
std::span<const NamedProbe> light_probes();
std::span<const NamedProbe> media_probes();
std::span<const NamedProbe> phase_probes();
std::span<const NamedProbe> sampler_probes();
std::span<const NamedProbe> scattering_probes();
std::span<const NamedProbe> sum_probes();
std::span<const NamedProbe> texture_probes();
std::span<const NamedProbe> warp_probes();
std::span<const NamedProbe> weight_probes();

/// Makes all probes known to files of cases.
void register_probes();

}  // namespace raylex::experiments
