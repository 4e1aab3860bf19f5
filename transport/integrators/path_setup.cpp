// The path integrator's parameters, and what it says of surfaces: geometric AOVs and user events.
#include <algorithm>
#include <limits>

#include "transport/integrators/path_state.h"

namespace raylex::transport {
namespace {

Result<std::unique_ptr<Integrator>> make_path(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    PathParameters p;
    auto depth = read_max_depth(entity, max_depth);
    if (!depth) return depth.error();
    p.max_depth = *depth;
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
    auto selection = entity.parameters.string_or("lightsampler", "power");
    if (!selection) return selection.error();
    // pbrt's other two choose by what a light can send to a point; power is the nearest to them that there is here.
    const std::vector<std::string> selections = {"power", "uniform", "bvh", "exhaustive"};
    if (std::find(selections.begin(), selections.end(), *selection) == selections.end())
        return error_at(entity.location,
                        "'lightsampler' is '" + *selection + "'; expected power, uniform, bvh or exhaustive",
                        nearest_name(*selection, selections));
    p.light_selection = *selection == "uniform" ? LightSelection::uniform : LightSelection::power;
    return make_path_integrator(p);
}

}  // namespace

std::unique_ptr<Integrator> make_path_integrator(const PathParameters& parameters) {
    return std::make_unique<PathIntegrator>(parameters);
}

Registry<IntegratorFactory>::Entry path_integrator_entry() {
    using T = ParameterType;
    return {"path",
            "path tracing with light sampling, multiple importance sampling and Russian roulette",
            {{"maxdepth", T::integer, "5", "scattering events at most; emission seen after the last still counts"},
             {"strategy", T::string, "mis", "how emitters are found: mis, light or scattering"},
             {"roulette", T::boolean, "true", "end weak paths at random from the second bounce"},
             {"lightsampler", T::string, "power",
              "which light a sample goes to: power or uniform; bvh and exhaustive of pbrt are power here"},
             {"regularize", T::boolean, "false", "not supported"}},
            make_path};
}

void PathIntegrator::report_surfaces(PathThread& thread, ThreadServices& services) const {
    const VertexBatch& v = thread.vertices;
    const auto& m = context_.world_to_camera;
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        for (const UserLobe lobe : {UserLobe::albedo, UserLobe::normal}) {
            if (!context_.events->wants(lobe)) continue;
            display::Tracker tracker = thread.trackers[row];
            services.lpe.move(tracker, context_.events->user(v.sources[j].label, lobe));
            services.lpe.move(tracker, context_.events->user_terminal());
            if (!services.lpe.channels_follow(tracker)) continue;
            const SurfacePoint& point = v.points[j];
            Rgb value;
            if (lobe == UserLobe::albedo) {
                value = v.bsdfs[j].albedo(point.wo);
            } else {
                const Vec3 n = face_forward(point.shading_normal, point.wo);
                for (int i = 0; i < 3; ++i) value[i] = m[i][0] * n.x + m[i][1] * n.y + m[i][2] * n.z;
            }
            services.lpe.contribute_user(value, thread.paths[row].beta, tracker);
        }
    }
}

void PathIntegrator::report_hidden_environments(PathThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const std::uint32_t row = v.rows[j];
    const PathState& path = thread.paths[row];
    const LightTable& lights = *context_.scene.lights;
    for (const std::uint32_t light : lights.environments()) {
        const Vec3& direction = v.rays[j].direction;
        if (lights.environment_density(choice(), light, direction) > 0) continue;
        const Rgb emitted = lights.environment_radiance(light, direction);
        display::Tracker tracker = thread.trackers[row];
        services.lpe.move(tracker, context_.events->terminal(light));
        services.lpe.contribute(Rgb(), display::Technique::scattering, tracker,
                                {emitted, path.beta * emitted, 0, false});
    }
}

}  // namespace raylex::transport
