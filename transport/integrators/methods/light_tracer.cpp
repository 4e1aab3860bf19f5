#include "transport/integrators/methods/light_tracer.h"

#include <algorithm>
#include <optional>

#include "transport/integrators/methods/path.h"
#include "transport/paths/subpaths/camera_connections.h"
#include "transport/paths/subpaths/light_subpaths.h"
#include "transport/paths/subpaths/live_lights.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {
namespace {

struct LightTracerThread final : IntegratorThread {
    LightTracerThread(const SceneView& scene, const EventTable& events, const LightSubpathOptions& options,
                      std::size_t capacity)
        : subpaths(scene, events, options, capacity) {
        counters.path_lengths.assign(std::min<std::size_t>(options.walk.max_depth, 1024) + 1, 0);
    }
    LightSubpaths subpaths;
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
        traits.holdouts = true;
        traits.user_events = true;
        traits.media = true;
        traits.first_hits = traits.cutouts = true;
        traits.saved_state = SavedState::none;
        traits.raster_splats = true;
        return traits;
    }
    Status prepare(const IntegratorContext& context) override {
        context_ = context;
        view_ = {context.camera, context.width, context.height, context.filter_radius};
        if (context.events->any()) language_.emplace(*context.lpe, *context.events);
        emitters_ = choose_live_lights(context.scene, *context.events, language_ ? &*language_ : nullptr,
                                       LightChoice::light_sampling, &display::LightForesight::Ahead::goes_on);
        can_emit_ = parameters_.max_depth > 0 && !emitters_.empty() && (context.beauty || context.events->any());
        not_begun_ = !can_emit_ && parameters_.max_depth > 0 && !context.scene.lights->lights().empty();
        if (can_emit_) media_of_lights_ = media_of_lights(context.scene, camera_position(context));
        return camera_->prepare(context);
    }
    [[nodiscard]] std::uint64_t pilot_rays() const override { return camera_->pilot_rays(); }
    [[nodiscard]] std::vector<std::string> omissions() const override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override {
        LightSubpathOptions options;
        options.walk = {parameters_.max_depth, parameters_.roulette_below, false};
        options.language = language_ ? &*language_ : nullptr;
        options.emitters = &emitters_;
        options.media_of_lights = media_of_lights_;
        auto thread = std::make_unique<LightTracerThread>(context_.scene, *context_.events, options,
                                                          static_cast<std::size_t>(context_.batch_capacity));
        thread->camera = camera_->make_thread_state();
        return thread;
    }
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    void connect(const CameraBatch& batch, LightTracerThread& thread, ThreadServices& services) const;

    DepthParameters parameters_;
    IntegratorContext context_;
    CameraView view_;
    std::unique_ptr<Integrator> camera_;  // what camera rays find by themselves
    std::vector<std::int32_t> media_of_lights_;
    std::optional<LightLanguage> language_;  // when channels read words
    LightChooser emitters_;
    bool can_emit_ = false;
    bool not_begun_ = false;  // light subpaths, which no word asks for
};

void LightTracer::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<LightTracerThread&>(state);
    camera_->integrate(batch, *thread.camera, services);
    thread.counters.add(thread.camera->counters);
    thread.camera->counters = IntegratorCounters();
    thread.camera->counters.path_lengths.assign(1, 0);
    if (services.left) return;
    if (!can_emit_) return thread.counters.count(Pruned::light_paths, not_begun_ ? batch.rays.size() : 0);
    LightSubpaths& subpaths = thread.subpaths;
    subpaths.begin(batch.rays, batch.samplers, services.lpe, thread.counters);
    while (subpaths.going() && !services.leaving()) {
        subpaths.advance(services.display);
        connect(batch, thread, services);
        subpaths.scatter([&](std::uint32_t row, const Rgb& power) { reject_power(services, batch.rows[row], power); });
    }
}

void LightTracer::connect(const CameraBatch& batch, LightTracerThread& thread, ThreadServices& services) const {
    const VertexBatch& v = thread.subpaths.vertices();
    const EmbreeScene& geometry = *context_.scene.geometry;
    for (std::size_t j = 0; j < v.count; ++j) {
        if (!thread.subpaths.ahead(j).seen) {
            thread.counters.count(Pruned::joins);
            continue;
        }
        const std::uint32_t row = v.rows[j];
        const Subpath& path = thread.subpaths.path(row);
        const Vec2 lens = context_.camera->has_lens()
                              ? batch.samplers[row].get_2d(
                                    subpath_dimensions<TransportMode::importance>.of(path.depth, camera_lens_dimension))
                              : Vec2{0, 0};
        const bool holdout = j < v.surfaces && geometry.has_holdouts() && geometry.is_holdout(v.hits[j]);
        thread.connections.add(
            view_, thread.subpaths.depth_limit(),
            {row, path.depth, thread.subpaths.vertex_depth(j), &v.points[j], &v.bsdfs[j], v.sources[j].offset, holdout,
             thread.subpaths.throughput(row), thread.subpaths.end(j), nullptr, v.hits[j].time,
             connection_key(context_.scene, batch.samplers[row], path.depth)},
            lens);
    }
    if (!context_.beauty && !geometry.has_alpha()) {
        Record record(*context_.events);
        record.begin(services.lpe);
        thread.connections.drop_dead(record, thread.counters);
    }
    thread.connections.splat(context_.scene, *context_.events, batch.rows, *services.raster, thread.counters);
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
            auto parameters = read_depth_parameters(entity, max_depth);
            if (!parameters) return parameters.error();
            return std::unique_ptr<Integrator>(std::make_unique<LightTracer>(*parameters));
        }};
}

}  // namespace raylex::transport
