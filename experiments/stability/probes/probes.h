// The tables of probes, one for each file of this folder.
#pragma once

#include <span>

#include "experiments/stability/probe.h"

namespace raylex::experiments {

std::span<const NamedProbe> enclosure_probes();
std::span<const NamedProbe> phase_probes();

}  // namespace raylex::experiments
