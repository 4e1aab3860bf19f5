#include "experiments/stability/probes/probes.h"

namespace raylex::experiments {

Registry<Probe>& probe_registry() {
    static Registry<Probe> registry = [] {
        Registry<Probe> all("probe");
        for (const std::span<const NamedProbe> table :
             {closed_mesh_probes(), elementary_probes(), enclosure_probes(), facet_probes(), file_probes(),
              geometry_probes(), light_probes(), media_probes(), phase_probes(), sampler_probes(), scattering_probes(),
              sum_probes(), texture_probes(), warp_probes(), weight_probes()})
            for (const NamedProbe& each : table) all.add({each.name, each.help, {}, each.probe});
        return all;
    }();
    return registry;
}

}  // namespace raylex::experiments
