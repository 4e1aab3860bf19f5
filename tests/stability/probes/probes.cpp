#include "tests/stability/probes/probes.h"

namespace raylex::experiments {

void register_probes() {
    for (const std::span<const NamedProbe> table :
         {closed_mesh_probes(), elementary_probes(), enclosure_probes(), facet_probes(), file_probes(),
          geometry_probes(), light_probes(), media_probes(), phase_probes(), sampler_probes(), scattering_probes(),
          sum_probes(), texture_probes(), warp_probes(), weight_probes()})
        for (const NamedProbe& each : table) probe_registry().add({each.name, each.help, {}, each.probe});
}

}  // namespace raylex::experiments
