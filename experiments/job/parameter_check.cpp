#include "experiments/job/parameter_check.h"

#include <algorithm>
#include <string>
#include <vector>

#include "display/buffer/pixel_filter.h"
#include "transport/import/known_parameters.h"
#include "transport/integrators/integrator.h"
#include "transport/scene/sampler.h"

namespace raylex::experiments {
namespace {

template <typename Factory>
Status check_entity(const std::optional<transport::SceneEntity>& entity, const Registry<Factory>& registry,
                    const std::string& kind) {
    if (!entity) return success();
    auto entry = registry.require(entity->type, entity->location);
    if (!entry) return entry.error();
    std::vector<std::string> known;
    for (const ParameterDescription& each : (*entry)->parameters) known.push_back(each.name);
    for (const Parameter& parameter : entity->parameters.parameters)
        if (std::find(known.begin(), known.end(), parameter.name) == known.end())
            return transport::unknown_parameter(kind, entity->type, parameter, known);
    return success();
}

/// Rejects a sampler of pbrt's that raylex replaces by another. In a scene file such a name is allowed; a job gets the
/// named sampler or an error.
Status check_own_sequence(const std::optional<transport::SceneEntity>& sampler) {
    if (!sampler) return success();
    const auto stands_in = [](const transport::SceneEntity& entity) {
        auto choice = transport::choose_sampler(entity);
        return choice && choice->stands_in ? choice->name : std::string();
    };
    const std::string instead = stands_in(*sampler);
    if (instead.empty()) return success();
    std::string own;
    for (const std::string& name : transport::sampler_registry().names()) {
        transport::SceneEntity plain;
        plain.type = name;
        if (stands_in(plain).empty()) own += (own.empty() ? "" : ", ") + name;
    }
    return error_at(sampler->location,
                    "there is no sampler '" + sampler->type + "'; in scene files '" + instead +
                        "' replaces it; expected one of: " + own,
                    "did you mean '" + instead + "'?");
}

}  // namespace

Status check_parameters(const Job& job) {
    if (Status s = check_entity(job.settings.paths.integrator, transport::integrator_registry(), "integrator"); !s)
        return s;
    for (const PassRequest& pass : job.passes)
        if (Status s = check_entity(std::optional(pass.method), transport::integrator_registry(), "integrator"); !s)
            return s;
    if (Status s = check_entity(job.settings.samples.sampler, transport::sampler_registry(), "sampler"); !s) return s;
    if (Status s = check_own_sequence(job.settings.samples.sampler); !s) return s;
    return check_entity(job.settings.film.filter, display::pixel_filter_registry(), "pixel filter");
}

}  // namespace raylex::experiments
