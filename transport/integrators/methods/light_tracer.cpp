#include "transport/integrators/methods/light_tracer.h"

#include <algorithm>

#include "transport/integrators/methods/path.h"
#include "transport/paths/subpaths/light_subpaths.h"

namespace raylex::transport {
namespace {

struct LightTracerThread final : IntegratorThread {
    LightTracerThread(const PathContext& context, const LightEmitters& emitters, const WalkOptions& options)
        : IntegratorThread(options.max_depth), light(context, emitters, options), connections(context) {}
    LightSubpaths light;
    CameraConnections connections;
    std::unique_ptr<IntegratorThread> camera;  // of the camera rays' part
};

class LightTracer final : public Integrator {
  public:
    explicit LightTracer(const DepthParameters& parameters) : parameters_(parameters) {
        PathParameters seen;
        seen.max_depth = 0;
        camera_ = make_path_integrator(seen);
    }
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.max_depth = parameters_.max_depth;
        traits.holdouts = traits.user_events = traits.media = traits.first_hits = traits.cutouts = true;
        traits.saved_state = SavedState::none;
        traits.raster_splats = true;
        return traits;
    }
    Status prepare(const IntegratorContext& context) override {
        context_ = context;
        emitters_ = LightEmitters(context_, parameters_.max_depth);
        return camera_->prepare(context);
    }
    [[nodiscard]] std::vector<std::string> omissions() const override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override {
        WalkOptions options;
        options.max_depth = parameters_.max_depth;
        options.roulette_below = parameters_.roulette_below;
        auto thread = std::make_unique<LightTracerThread>(context_, emitters_, options);
        thread->camera = camera_->make_thread_state();
        return thread;
    }
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    DepthParameters parameters_;
    IntegratorContext context_;
    LightEmitters emitters_;
    std::unique_ptr<Integrator> camera_;  // what camera rays find by themselves
};

void LightTracer::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<LightTracerThread&>(state);
    camera_->integrate(batch, *thread.camera, services);
    thread.counters.take(thread.camera->counters);
    if (services.left) return;
    LightSubpaths& light = thread.light;
    light.begin(batch, services, thread.counters);
    while (light.advance(services)) {
        const VertexBatch& v = light.vertices();
        for (std::size_t j = 0; j < v.count; ++j)
            thread.connections.add(light.vertex(j), v.points[j], v.bsdfs[j], light.throughput(v.rows[j]),
                                   light.depth_limit(), batch.samplers[v.rows[j]], thread.counters);
        thread.connections.splat(batch.rows, services, thread.counters);
        light.scatter();
    }
    for (const InvalidPower& each : light.invalid_powers()) reject_power(services, batch.rows[each.row], each.power);
}

std::vector<std::string> LightTracer::omissions() const {
    std::vector<LobeId> lobes;
    bool curves = false;
    for (const ShapeGeometry& shape : context_.scene.geometry->shapes()) {
        if (shape.interface) continue;
        context_.scene.materials->material(static_cast<std::size_t>(shape.material))->append_lobes(lobes);
        curves = curves || shape.faces_rays;
    }
    const bool singular = std::any_of(lobes.begin(), lobes.end(),
                                      [](LobeId lobe) { return lobe_kinds()[lobe].scatter == lpe::Scatter::singular; });
    std::vector<std::string> omitted;
    if (context_.scene.media->any_emits() && parameters_.max_depth > 0)
        omitted.emplace_back(
            "integrator 'lighttracer' finds light that media emit only where the camera sees it directly: "
            "C.+O is missing from the image");
    if (context_.events->wants_user() && parameters_.max_depth > 0)
        omitted.emplace_back(
            "integrator 'lighttracer' asks surfaces what they say of themselves (user events) only where the camera "
            "sees them directly: C.+U is missing from such layers");
    if (curves && parameters_.max_depth > 0)
        omitted.emplace_back(
            "integrator 'lighttracer' sees flat curves and tubes from where light comes, not from the camera: "
            "they look otherwise than with 'path' or 'bdpt'");
    if (!singular || parameters_.max_depth == 0) return omitted;
    omitted.emplace_back(
        "integrator 'lighttracer' does not find what the camera sees by a mirror or through smooth glass: paths whose "
        "first "
        "scattering is singular (C<.S>.* in the osl dialect) are missing from the image");
    return omitted;
}

}  // namespace

Registry<IntegratorFactory>::Entry light_tracer_entry() {
    return {
        "lighttracer",
        "paths from the lights, connected to the camera; finds caustics, but nothing seen in mirrors or through glass",
        describe_depth_parameters("paths"),
        [](const SceneEntity& entity, std::optional<std::int64_t> max_depth) -> Result<std::unique_ptr<Integrator>> {
            IntegratorParameters read(entity);
            const DepthParameters parameters = read_depth_parameters(read, max_depth);
            if (read.error()) return *read.error();
            return std::unique_ptr<Integrator>(std::make_unique<LightTracer>(parameters));
        }};
}

}  // namespace raylex::transport
