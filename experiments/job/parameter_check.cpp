#include "experiments/job/parameter_check.h"

#include <algorithm>
#include <string>
#include <vector>

#include "display/buffer/pixel_filter.h"
#include "transport/import/known_parameters.h"
#include "transport/integrators/integrator.h"
#include "transport/samplers/sampler.h"

namespace raylex::experiments {
namespace {

template <typename Factory>
Status check_entity(const std::optional<transport::SceneEntity>& entity, const Registry<Factory>& registry,
                    const std::string& kind) {
    if (!entity) return success();
    const auto* entry = registry.find(entity->type);
    if (entry == nullptr) return success();
    std::vector<std::string> known;
    for (const ParameterDescription& each : entry->parameters) known.push_back(each.name);
    for (const Parameter& parameter : entity->parameters.parameters)
        if (std::find(known.begin(), known.end(), parameter.name) == known.end())
            return transport::unknown_parameter(kind, entity->type, parameter, known);
    return success();
}

}  // namespace

Status check_parameters(const Job& job) {
    if (Status s = check_entity(job.settings.integrator, transport::integrator_registry(), "integrator"); !s) return s;
    if (Status s = check_entity(job.settings.sampler, transport::sampler_registry(), "sampler"); !s) return s;
    return check_entity(job.settings.filter, display::pixel_filter_registry(), "pixel filter");
}

}  // namespace raylex::experiments
