#include "transport/integrators/methods/light_tracer.h"

#include "transport/integrators/methods/path.h"
#include "transport/paths/subpaths/light_subpaths.h"

namespace raylex::transport {
namespace {

struct LightTracerThread final : IntegratorThread {
    LightTracerThread(const PathContext& context, const LightEmitters& emitters, const WalkOptions& options)
        : IntegratorThread(options.max_depth), light(context, emitters, options), connections(context) {}
    LightSubpaths light;
    CameraConnections connections;
    std::unique_ptr<IntegratorThread> camera;
};

class LightTracer final : public Integrator {
  public:
    explicit LightTracer(const WalkOptions& options) : options_(options) {}
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.max_depth = options_.max_depth;
        traits.holdouts = traits.user_events = traits.media = traits.first_hits = traits.cutouts = true;
        traits.raster_splats = true;
        traits.saved_state = SavedState::none;
        return traits;
    }
    Status prepare(const IntegratorContext& context) override {
        context_ = context;
        emitters_ = LightEmitters(context_, options_.max_depth);
        return camera_->prepare(context);
    }
    [[nodiscard]] std::vector<Omission> omissions() const override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override {
        auto thread = std::make_unique<LightTracerThread>(context_, emitters_, options_);
        thread->camera = camera_->make_thread_state();
        return thread;
    }
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    const WalkOptions options_;
    IntegratorContext context_;
    LightEmitters emitters_;
    std::unique_ptr<Integrator> camera_ = make_path_integrator({{.max_depth = 0}});  // what the camera sees directly
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

std::vector<Omission> LightTracer::omissions() const {
    if (options_.max_depth == 0) return {};
    const SceneView& scene = context_.scene;
    const UnconnectedSurfaces unconnected = unconnected_surfaces(scene);
    struct Cause {
        bool applies;
        const char* text;
        bool is_declared;
    };
    const Cause causes[] = {
        {scene.media->any_emits(),
         "finds light that media emit only where the camera sees it directly: C.+O is missing from the image", true},
        {context_.events->wants_user(),
         "reports user events of surfaces only where the camera sees them directly: C.+U is "
         "missing from such layers",
         false},
        {unconnected.curves,
         "sees flat curves and tubes from where light comes, not from the camera: they look otherwise than with "
         "'path' or 'bdpt'",
         false},
        {unconnected.specular,
         "does not find what the camera sees by a mirror or through smooth glass: paths whose first scattering is "
         "singular (C<.S>.* in the osl dialect) are missing from the image",
         true}};
    std::vector<Omission> omitted;
    for (const Cause& each : causes)
        if (each.applies) omitted.push_back({std::string("integrator 'lighttracer' ") + each.text, each.is_declared});
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
            return std::unique_ptr<Integrator>(std::make_unique<LightTracer>(
                WalkOptions{.max_depth = parameters.max_depth, .roulette_below = parameters.roulette_below}));
        }};
}

}  // namespace raylex::transport
