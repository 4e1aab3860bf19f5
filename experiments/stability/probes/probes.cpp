#include "experiments/stability/probes/probes.h"

namespace raylex::experiments {

Registry<Probe>& probe_registry() {
    static Registry<Probe> registry = [] {
        Registry<Probe> all("probe");
        for (const std::span<const NamedProbe> table : {enclosure_probes(), phase_probes()})
            for (const NamedProbe& each : table) all.add({each.name, each.help, {}, each.probe});
        return all;
    }();
    return registry;
}

}  // namespace raylex::experiments
