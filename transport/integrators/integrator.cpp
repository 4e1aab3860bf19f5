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

Vec3 camera_position(const IntegratorContext& context) {
    return context.camera->generate({0, 0, {0.5f, 0.5f}}).origin;
}

Result<std::uint32_t> read_max_depth(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    auto depth = entity.parameters.integer_or("maxdepth", 5);
    if (!depth) return depth.error();
    if (max_depth) *depth = *max_depth;
    if (*depth < 0)
        return error_at(entity.location,
                        "'maxdepth' is " + std::to_string(*depth) + "; expected 0 or more scattering events");
    return static_cast<std::uint32_t>(std::min<std::int64_t>(*depth, 1'000'000));
}

Result<DepthParameters> read_depth_parameters(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    auto depth = read_max_depth(entity, max_depth);
    if (!depth) return depth.error();
    auto roulette = read_roulette(entity);
    if (!roulette) return roulette.error();
    return DepthParameters{*depth, *roulette};
}

Result<Real> read_roulette(const SceneEntity& entity) {
    auto roulette = entity.parameters.boolean_or("roulette", true);
    if (!roulette) return roulette.error();
    auto below = entity.parameters.real_or("rrthreshold", double{default_roulette_below});
    if (!below) return below.error();
    if (!(*below >= 0 && *below <= 1))
        return error_at(entity.location, "'rrthreshold' is " + std::to_string(*below) +
                                             "; expected at most 1, and 0 where paths never end at random");
    return *roulette ? static_cast<Real>(*below) : Real(0);
}

ParameterDescription describe_roulette(const std::string& who) {
    return {"roulette", ParameterType::boolean, "true", "end weak " + who + " at random from the second bounce"};
}

ParameterDescription describe_roulette_threshold() {
    return {"rrthreshold", ParameterType::real, "0.25",
            "throughput below which roulette is played (pbrt-v4: always 1); 0: never"};
}

std::vector<ParameterDescription> describe_depth_parameters(const std::string& who) {
    using T = ParameterType;
    return {{"maxdepth", T::integer, "5", "scattering events at most; emission seen after the last still counts"},
            describe_roulette(who),
            describe_roulette_threshold()};
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
