#include "transport/paths/subpaths/direct_light.h"

#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

LightChoice light_choice(LightSelection selection, PathStrategy strategy) {
    const bool all = strategy == PathStrategy::light;
    if (selection == LightSelection::uniform)
        return all ? LightChoice::light_sampling_uniform : LightChoice::mis_uniform;
    return all ? LightChoice::light_sampling : LightChoice::mis;
}

DirectLight::DirectLight(const PathContext& context, LightSelection selection, PathStrategy strategy)
    : context_(&context), strategy_(strategy) {
    const LightChoice choice = light_choice(selection, strategy);
    const bool by_receiver = selection == LightSelection::receiver;
    if (context.plan != nullptr && context.plan->lights && context.plan->lights->is_of(choice, by_receiver))
        lights_ = context.plan->lights;
    else lights_ = std::make_shared<const LiveLights>(context.scene, *context.events, choice, by_receiver);
}

DirectLight::DirectLight(const PathContext& context, const LightLanguage* language)
    : context_(&context),
      lights_(
          std::make_shared<const LiveLights>(LiveLights::alike_everywhere(context.scene, *context.events, language))) {}

bool DirectLight::draw(CameraSubpaths& camera, std::size_t j, bool planned, LightSample& sample) const {
    const SceneView& scene = context_->scene;
    const VertexBatch& v = camera.vertices();
    const std::uint32_t row = v.rows[j];
    const SurfacePoint& point = v.points[j];
    const PixelSampler& sampler = camera.sampler(row);
    const std::uint32_t depth = camera.path(row).depth;
    std::uint8_t lights = chooser().empty() ? LiveLights::none : LiveLights::all;
    TechniqueShares shares;
    if (planned && !v.bsdfs[j].depends_on_weights())
        shares.light = context_->directions->light_share(point, camera.path(row).beta.average());
    const bool takes_all = camera.record().takes_all(row);
    if (!takes_all) {
        const display::Liveness::LiveSet live = camera.record().live_set(row, v.sources[j].label, point.material);
        if (!live.anything) return false;
        lights = lights_->of(live);
        if (!live.scatters && lights != LiveLights::none && context_->plan != nullptr) shares = context_->plan->shares;
    }
    if (planned || !takes_all) camera.choose_techniques(row, lights, shares);
    IntegratorCounters& counters = camera.counters();
    if (lights == LiveLights::none) {
        counters.count(Pruned::light_samples);
        return false;
    }
    if (shares.light < 1 && !(sampler.get_random(light_technique_dimensions + depth) < shares.light)) {
        counters.count(Pruned::light_samples_left_to_rays);
        return false;
    }
    const LightChooser& chosen = (*lights_)[lights];
    constexpr const SubpathDimensions& dimensions = subpath_dimensions<TransportMode::radiance>;
    const Real u_choice = chosen.needs_number() ? sampler.get_1d(dimensions.of(depth, light_choice_dimension)) : 0.0f;
    if (!scene.lights->sample(chosen, *scene.geometry, {point.position, point.shading_normal}, u_choice, camera.pair(j),
                              sample))
        return false;
    if (!camera.can_connect(j, sample.wi)) return false;
    if (scene.tests_alpha()) sample.radiance *= emitter_opacity(scene, sample, point.position);
    sample.pdf *= shares.light;
    return strategy_ != PathStrategy::scattering || sample.delta;
}

Real DirectLight::density(const CameraSubpaths& camera, const EmitterHit& hit) const {
    const Subpath& path = camera.path(hit.row);
    if (path.specular || strategy_ == PathStrategy::scattering) return 0;
    const SceneView& scene = context_->scene;
    return camera.technique_shares(hit.row).light * scene.lights->density((*lights_)[path.lights], *scene.geometry,
                                                                          hit.light, {path.from, path.from_normal},
                                                                          hit.point, hit.hit);
}

Real DirectLight::density(const CameraSubpaths& camera, const EscapedRay& ray, std::uint32_t light) const {
    const Subpath& path = camera.path(ray.row);
    if (path.specular || strategy_ == PathStrategy::scattering) return 0;
    return camera.technique_shares(ray.row).light *
           context_->scene.lights->environment_density((*lights_)[path.lights], light, path.from, ray.direction);
}

void DirectLight::report_hidden_environments(const CameraSubpaths& camera) const {
    const LightTable& lights = *context_->scene.lights;
    const Record& record = camera.record();
    for (const SurfaceArrival& at : camera.arrivals()) {
        const Subpath& path = camera.path(at.row);
        if (path.specular) continue;
        for (const std::uint32_t light : lights.environments()) {
            if (lights.environment_density(chooser(), light, path.from, at.direction) > 0) continue;
            const Rgb emitted = lights.environment_radiance(light, path.from, at.direction);
            record.arrive(at.row, record.events().terminal(light), {0, path.depth + 2},
                          {.emitted = emitted, .unweighted = at.throughput * emitted, .visibility = 0});
        }
    }
}

}  // namespace raylex::transport
