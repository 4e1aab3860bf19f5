#include "transport/integrators/integrator.h"

#include <algorithm>

#include "transport/cameras/camera.h"
#include "transport/integrators/methods/bdpt.h"
#include "transport/integrators/methods/light_tracer.h"
#include "transport/integrators/methods/path.h"
#include "transport/integrators/methods/pssmlt.h"
#include "transport/integrators/pbrt_integrators.h"

namespace raylex::transport {

Registry<IntegratorFactory>& integrator_registry() {
    static Registry<IntegratorFactory> registry = [] {
        Registry<IntegratorFactory> r("integrator");
        r.add(path_integrator_entry());
        auto media_too = path_integrator_entry();
        media_too.name = "volpath";
        media_too.help = "another name for path, which takes participating media as they come";
        r.add(media_too);
        r.add(light_tracer_entry());
        r.add(bdpt_entry());
        r.add(pssmlt_entry());
        return r;
    }();
    return registry;
}

void reject_power(ThreadServices& services, const display::CameraRow& row, const Rgb& power) {
    const display::Tracker tracker = services.raster->begin(0, 0, row);
    services.raster->lpe().contribute(to_float(power), {}, tracker);
}

SceneEntity integrator_for(const std::optional<SceneEntity>& asked, const SceneEntity& of_scene) {
    if (!asked) return of_scene;
    SceneEntity entity = *asked;
    const auto* entry = integrator_registry().find(entity.type.empty() ? "path" : entity.type);
    if (entry == nullptr) return entity;
    for (const Parameter& each : of_scene.parameters.parameters) {
        const auto named = [&](const auto& other) { return other.name == each.name; };
        const std::vector<ParameterDescription>& known = entry->parameters;
        const std::vector<Parameter>& given = entity.parameters.parameters;
        if (std::any_of(known.begin(), known.end(), named) && std::none_of(given.begin(), given.end(), named))
            entity.parameters.parameters.push_back(each);
        else each.used = true;  // of the scene's integrator, which is not asked for
    }
    return entity;
}

Result<ChosenIntegrator> choose_integrator(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    ChosenIntegrator chosen;
    SceneEntity asked = entity;
    if (asked.type.empty()) asked.type = "path";
    if (!integrator_registry().find(asked.type)) {
        auto substitute = substitute_for_pbrt(asked);
        if (!substitute) return substitute.error();
        if (*substitute) {
            chosen.warnings.push_back(
                error_at(asked.location, "integrator '" + asked.type + "' " + (*substitute)->note));
            chosen.samples_per_pixel = (*substitute)->samples_per_pixel;
            asked = std::move((*substitute)->entity);
        }
    }
    auto entry = integrator_registry().require(asked.type, asked.location);
    if (!entry) return entry.error();
    auto made = (*entry)->factory(asked, max_depth);
    if (!made) return made.error();
    for (const Parameter* p : asked.parameters.unused()) {
        std::vector<std::string> names;
        for (const ParameterDescription& each : (*entry)->parameters) names.push_back(each.name);
        chosen.warnings.push_back(error_at(p->location,
                                           "integrator '" + asked.type + "' has no parameter '" + p->name + "'",
                                           near_miss(p->name, names)));
    }
    for (const Parameter& p : entity.parameters.parameters) p.used = true;
    chosen.integrator = std::move(*made);
    chosen.name = asked.type;
    return chosen;
}

}  // namespace raylex::transport
