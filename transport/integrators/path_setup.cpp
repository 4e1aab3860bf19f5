// The path integrator's parameters and its geometric AOVs.
#include <algorithm>
#include <limits>

#include "transport/integrators/path_state.h"

namespace raylex::transport {
namespace {

Result<std::unique_ptr<Integrator>> make_path(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    PathParameters p;
    auto depth = entity.parameters.integer_or("maxdepth", 5);
    if (!depth) return depth.error();
    if (max_depth) *depth = *max_depth;
    if (*depth < 0)
        return error_at(entity.location,
                        "'maxdepth' is " + std::to_string(*depth) + "; expected 0 or more scattering events");
    p.max_depth = static_cast<std::uint32_t>(std::min<std::int64_t>(*depth, 1'000'000));
    auto strategy = entity.parameters.string_or("strategy", "mis");
    if (!strategy) return strategy.error();
    const std::vector<std::string> names = {"mis", "light", "scattering"};
    const auto found = std::find(names.begin(), names.end(), *strategy);
    if (found == names.end())
        return error_at(entity.location, "'strategy' is '" + *strategy + "'; expected mis, light or scattering",
                        nearest_name(*strategy, names));
    p.strategy = static_cast<PathStrategy>(found - names.begin());
    auto roulette = entity.parameters.boolean_or("roulette", true);
    if (!roulette) return roulette.error();
    p.roulette = *roulette;
    auto regularize = entity.parameters.boolean_or("regularize", false);
    if (!regularize) return regularize.error();
    if (*regularize)
        return error_at(entity.location, "'regularize' is not supported: it would blur specular lobes; remove it");
    static_cast<void>(entity.parameters.find("lightsampler"));  // changes noise, never the image
    return std::unique_ptr<Integrator>(std::make_unique<PathIntegrator>(p));
}

}  // namespace

Registry<IntegratorFactory>::Entry path_integrator_entry() {
    using T = ParameterType;
    return {"path",
            "path tracing with light sampling, multiple importance sampling and Russian roulette",
            {{"maxdepth", T::integer, "5", "scattering events at most; emission seen after the last still counts"},
             {"strategy", T::string, "mis", "how emitters are found: mis, light or scattering"},
             {"roulette", T::boolean, "true", "end weak paths at random from the second bounce"},
             {"lightsampler", T::string, "", "accepted for pbrt's sake; lights are chosen by power"},
             {"regularize", T::boolean, "false", "not supported"}},
            make_path};
}

void PathIntegrator::write_aovs(PathThread& thread, ThreadServices& services) const {
    if (context_.aovs->empty()) return;
    const VertexBatch& v = thread.vertices;
    geoaovs::ShadingBatch& out = thread.first_hits;
    out.resize(static_cast<int>(v.count));
    std::copy(&context_.world_to_camera[0][0], &context_.world_to_camera[0][0] + 12, &out.world_to_camera[0][0]);
    std::size_t count = 0;
    for (std::size_t j = 0; j < v.count; ++j) {
        const PathState& path = thread.paths[v.rows[j]];
        if (path.depth != 0) continue;
        const SurfacePoint& point = v.points[j];
        const Vec3 ns = face_forward(point.shading_normal, point.wo),
                   ng = face_forward(point.geometric_normal, point.wo);
        const Rgb albedo = context_.aovs->wants_albedo() ? v.bsdfs[j].albedo(point.wo) : Rgb();
        for (int c = 0; c < 3; ++c) {
            out.position[c][count] = point.position[c];
            out.shading_normal[c][count] = ns[c];
            out.geometric_normal[c][count] = ng[c];
            out.albedo[c][count] = albedo[c];
        }
        out.row[count] = static_cast<std::int32_t>(v.rows[j]);
        out.s[count] = point.u;
        out.t[count] = point.v;
        out.distance[count] = path.travelled + v.hits[j].t;
        out.object_id[count] = v.sources[j].object_id;
        ++count;
    }
    out.count = static_cast<int>(count);
    if (count > 0) context_.aovs->write(out, services.display);
}

}  // namespace raylex::transport
