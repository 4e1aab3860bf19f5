// The light tracer's parameters, and what it says of itself and of a scene.
#include <algorithm>

#include "transport/integrators/light_tracer_state.h"

namespace raylex::transport {
namespace {

Result<std::unique_ptr<Integrator>> make_light_tracer(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    LightTracerParameters p;
    auto depth = read_max_depth(entity, max_depth);
    if (!depth) return depth.error();
    p.max_depth = *depth;
    auto roulette = entity.parameters.boolean_or("roulette", true);
    if (!roulette) return roulette.error();
    p.roulette = *roulette;
    return std::unique_ptr<Integrator>(std::make_unique<LightTracer>(p));
}

}  // namespace

Registry<IntegratorFactory>::Entry light_tracer_entry() {
    using T = ParameterType;
    return {"lighttracer",
            "paths from the lights, connected to the camera; finds caustics, but nothing seen in mirrors or through glass",
            {{"maxdepth", T::integer, "5", "scattering events at most; emission seen after the last still counts"},
             {"roulette", T::boolean, "true", "end weak paths at random from the second bounce"}},
            make_light_tracer};
}

LightTracer::LightTracer(const LightTracerParameters& parameters) : parameters_(parameters) {
    PathParameters seen;
    seen.max_depth = 0;
    camera_ = make_path_integrator(seen);
}

IntegratorTraits LightTracer::traits() const {
    IntegratorTraits traits;
    traits.max_depth = parameters_.max_depth;
    traits.saved_state = SavedState::none;
    traits.raster_splats = true;
    return traits;
}

Status LightTracer::prepare(const IntegratorContext& context) {
    context_ = context;
    reads_words_ = context.events->any();
    can_emit_ = parameters_.max_depth > 0 && context.scene.lights->can_sample(LightChoice::light_sampling) &&
                (context.beauty || reads_words_);
    return camera_->prepare(context);
}

std::vector<std::string> LightTracer::omissions() const {
    std::vector<LobeId> lobes;
    for (const ShapeGeometry& shape : context_.scene.geometry->shapes())
        if (!shape.interface)
            context_.scene.materials->material(static_cast<std::size_t>(shape.material))->append_lobes(lobes);
    const bool singular = std::any_of(lobes.begin(), lobes.end(), [](LobeId lobe) {
        return lobe_kinds()[lobe].scatter == lpe::Scatter::singular;
    });
    if (!singular || parameters_.max_depth == 0) return {};
    return {"integrator 'lighttracer' does not find what the camera sees by a mirror or through smooth glass: paths whose first "
            "scattering is singular (C<.S>.* in the osl dialect) are missing from the image"};
}

std::unique_ptr<IntegratorThread> LightTracer::make_thread_state() const {
    auto thread = std::make_unique<LightThread>(static_cast<std::size_t>(context_.batch_capacity),
                                                std::min<std::size_t>(parameters_.max_depth, 1024) + 1);
    thread->camera = camera_->make_thread_state();
    return thread;
}

}  // namespace raylex::transport
