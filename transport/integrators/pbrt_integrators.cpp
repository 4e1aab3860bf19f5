#include "transport/integrators/pbrt_integrators.h"

#include <algorithm>
#include <initializer_list>

#include "transport/scene/typed_parameters.h"

namespace raylex::transport {
namespace {

/// `type` with those of the entity's parameters that are named.
SceneEntity renamed(const SceneEntity& entity, const std::string& type, std::initializer_list<const char*> kept) {
    SceneEntity result = entity;
    result.type = type;
    std::erase_if(result.parameters.parameters, [&](const Parameter& p) {
        return std::none_of(kept.begin(), kept.end(), [&](const char* name) { return p.name == name; });
    });
    return result;
}

/// Paths without roulette, which find light by `strategy`.
SceneEntity plain_path(const SceneEntity& entity, const std::string& strategy) {
    SceneEntity path = renamed(entity, "path", {"maxdepth"});
    path.parameters.parameters.push_back(typed::text("strategy", strategy));
    path.parameters.parameters.push_back(typed::boolean("roulette", false));
    return path;
}

const char* const also_samples = "; lights that no ray can hit are sampled, too, where pbrt leaves them out";

Result<std::optional<IntegratorSubstitute>> metropolis(const SceneEntity& entity) {
    SceneEntity chains =
        renamed(entity, "pssmlt", {"maxdepth", "bootstrapsamples", "chains", "largestepprobability", "sigma"});
    chains.parameters.parameters.push_back(typed::text("integrator", "bdpt"));
    auto mutations = entity.parameters.integer_or("mutationsperpixel", 100);
    if (!mutations) return mutations.error();
    if (*mutations < 1)
        return error_at(entity.location,
                        "'mutationsperpixel' is " + std::to_string(*mutations) + "; expected at least 1");
    return std::optional(IntegratorSubstitute{
        std::move(chains),
        "is rendered with 'pssmlt' over bidirectional paths (Kelemen et al. 2002): same mean, where pbrt's chains are "
        "of one path length and one strategy each",
        static_cast<std::uint64_t>(*mutations)});
}

Result<std::optional<IntegratorSubstitute>> simple_path(const SceneEntity& entity) {
    auto samples_lights = entity.parameters.boolean_or("samplelights", true),
         samples_bsdf = entity.parameters.boolean_or("samplebsdf", true);
    if (!samples_lights) return samples_lights.error();
    if (!samples_bsdf) return samples_bsdf.error();
    std::string note =
        *samples_lights
            ? "is rendered with 'path', strategy 'light', without roulette: same mean"
            : std::string("is rendered with 'path', strategy 'scattering', without roulette") + also_samples;
    if (!*samples_bsdf) note += "; directions are drawn by the material all the same";
    return std::optional(
        IntegratorSubstitute{plain_path(entity, *samples_lights ? "light" : "scattering"), std::move(note), {}});
}

}  // namespace

Result<std::optional<IntegratorSubstitute>> substitute_for_pbrt(const SceneEntity& entity) {
    const auto as = [](SceneEntity made, std::string note) {
        return std::optional(IntegratorSubstitute{std::move(made), std::move(note), {}});
    };
    const std::string& type = entity.type;
    if (type == "mlt") return metropolis(entity);
    if (type == "simplepath") return simple_path(entity);
    if (type == "lightpath")
        return as(renamed(entity, "lighttracer", {"maxdepth"}),
                  "is rendered with 'lighttracer', which plays roulette and traces what the camera sees directly");
    if (type == "sppm") {
        SceneEntity bdpt = renamed(entity, "bdpt", {"maxdepth"});
        bdpt.parameters.parameters.push_back(typed::boolean("countmirrors", false));
        return as(std::move(bdpt),
                  "is rendered with 'bdpt', which does not blur but finds caustics of lights without extent neither in "
                  "mirrors nor through glass");
    }
    if (type == "simplevolpath" || type == "randomwalk")
        return as(plain_path(entity, "scattering"),
                  std::string("is rendered with 'path', strategy 'scattering', without roulette") + also_samples);
    if (type == "ambientocclusion")
        return as(renamed(entity, "path", {"maxdepth"}),
                  "is not available: it is a picture of openness and no light transport; rendering with 'path'");
    if (type == "function")
        return as(renamed(entity, "path", {"maxdepth"}),
                  "is not available: it plots a function of sample points and no scene; rendering with 'path'");
    return std::optional<IntegratorSubstitute>();
}

}  // namespace raylex::transport
