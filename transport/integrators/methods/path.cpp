#include "transport/integrators/methods/path.h"

#include <algorithm>

#include "transport/integrators/first_hits.h"
#include "transport/integrators/pilots/last_vertex.h"
#include "transport/integrators/pilots/roulette_pilot.h"
#include "transport/integrators/pilots/split_pilot.h"
#include "transport/math/sampling.h"
#include "transport/paths/subpaths/connect.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {
namespace {

struct PathThread final : IntegratorThread {
    PathThread(const SceneView& scene, const EventTable& events, const CameraSubpathOptions& options,
               std::size_t capacity)
        : camera(scene, events, options, capacity), connections(scene) {
        // Longer paths than 1024 share the histogram's last slot.
        counters.path_lengths.assign(std::min<std::size_t>(options.walk.max_depth, 1024) + 1, 0);
    }
    CameraSubpaths camera;
    Connections connections;
    geoaovs::ShadingBatch first_hits;
};

class PathIntegrator final : public Integrator, private PathTrials {
  public:
    explicit PathIntegrator(const PathParameters& parameters) : parameters_(parameters) {}
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.emitter_samples = traits.holdouts = traits.user_events = traits.media = traits.camera_weights = true;
        traits.first_hits = traits.cutouts = true;
        traits.light_samples = parameters_.strategy != PathStrategy::scattering;
        traits.max_depth = parameters_.max_depth;
        traits.regularizes = parameters_.regularize;
        traits.saved_state = SavedState::none;
        return traits;
    }
    [[nodiscard]] std::uint64_t pilot_rays() const override { return pilot_rays_; }
    Status prepare(const IntegratorContext& context) override {
        context_ = context;
        pilot_rays_ = 0;
        lights_ = LiveLights(context.scene, *context.events, choice(),
                             parameters_.light_selection == LightSelection::receiver);
        can_sample_lights_ = !lights_[LiveLights::all].empty();
        const bool scatters =
            parameters_.max_depth > 0 && context.events->any() && context.events->foresight().at_camera().scatters;
        if (!may_prune() || !scatters || parameters_.strategy != PathStrategy::mis) return success();
        if (can_sample_lights_ && parameters_.roulette_below > 0)
            at_last_ = choose_techniques(context, lights_, pilot_rays_);
        SplitChoice splits;
        if (parameters_.splits) splits = choose_splits(context, *this, pilot_rays_);
        if (parameters_.channel_roulette && parameters_.roulette_below > 0)
            roulette_ = choose_roulette(context, *this, splits, parameters_.roulette_below, pilot_rays_);
        splits_ = splits.plan;
        return success();
    }
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    struct Ends;
    void sample_light(PathThread& thread, std::size_t j) const;
    /// Whether channels alone decide what is drawn; beauty's numbers do not depend on them (Law 2).
    [[nodiscard]] bool may_prune() const { return !context_.beauty && context_.events->prunes(); }
    [[nodiscard]] std::unique_ptr<Integrator> trial(const SplitPlan& plan, std::uint32_t most_depth,
                                                    PathWatch* watch) const override;
    /// Whether light sampling finds the emitter too to which `light_pdf` belongs.
    [[nodiscard]] bool sampled_too(const Subpath& path, Real light_pdf) const {
        return !path.specular && light_pdf > 0 && parameters_.strategy != PathStrategy::scattering;
    }
    [[nodiscard]] LightChoice choice() const {
        const bool all = parameters_.strategy == PathStrategy::light;
        if (parameters_.light_selection == LightSelection::uniform)
            return all ? LightChoice::light_sampling_uniform : LightChoice::mis_uniform;
        return all ? LightChoice::light_sampling : LightChoice::mis;
    }

    PathParameters parameters_;
    IntegratorContext context_;
    LiveLights lights_;
    TechniqueShares at_last_;  // where only light can follow a vertex
    bool can_sample_lights_ = false;
    SplitPlan splits_;
    RouletteTable roulette_;
    PathWatch* watch_ = nullptr;  // of a pilot's
    std::uint64_t pilot_rays_ = 0;
};

std::unique_ptr<Integrator> PathIntegrator::trial(const SplitPlan& plan, std::uint32_t most_depth,
                                                  PathWatch* watch) const {
    auto trial = std::make_unique<PathIntegrator>(*this);
    trial->parameters_.max_depth = std::min(parameters_.max_depth, most_depth);
    if (watch != nullptr) trial->parameters_.roulette_below = 0;
    trial->context_.scene
        .general_code = {};  // what effects that are forced on cost changes no choice, as it does no bit
    trial->splits_ = plan;
    trial->watch_ = watch;
    return trial;
}

std::unique_ptr<IntegratorThread> PathIntegrator::make_thread_state() const {
    CameraSubpathOptions options = camera_subpath_options(
        context_, {parameters_.max_depth, parameters_.roulette_below, false, parameters_.regularize});
    options.live_lobes = may_prune();
    options.first_depth = parameters_.first_depth;
    options.splits = splits_;
    if (!roulette_.empty()) options.roulette = &roulette_;
    options.watch = watch_;
    return std::make_unique<PathThread>(context_.scene, *context_.events, options,
                                        static_cast<std::size_t>(context_.batch_capacity));
}

/// Emitters found by scattering.
struct PathIntegrator::Ends : CameraEnds {
    const PathIntegrator& self;
    CameraSubpaths& camera;

    void emits(std::size_t j) {
        const VertexBatch& v = camera.vertices();
        const SceneView& scene = self.context_.scene;
        const std::uint32_t light = scene.geometry->shapes()[v.hits[j].shape].first_light + v.hits[j].primitive;
        const Rgb emitted = scene.lights->emitted(light, v.points[j], v.points[j].wo);
        if (emitted.is_black()) return;
        const Subpath& path = camera.path(v.rows[j]);
        add(v.rows[j], light, emitted,
            path.specular
                ? 0.0f
                : path.light_share * scene.lights->density(self.lights_[path.lights], *scene.geometry, light,
                                                           {path.from, path.from_normal}, v.points[j], v.hits[j]));
    }
    void escapes(std::uint32_t row, const Ray& ray) {
        const LightTable& lights = *self.context_.scene.lights;
        const Subpath& path = camera.path(row);
        for (const std::uint32_t light : lights.environments())
            add(row, light, lights.environment_radiance(light, path.from, ray.direction),
                path.specular ? 0.0f
                              : path.light_share * lights.environment_density(self.lights_[path.lights], light,
                                                                              path.from, ray.direction));
    }
    void volume_emits(std::uint32_t row, const Rgb& emitted) {
        const Subpath& path = camera.path(row);
        if (path.depth < self.parameters_.first_depth) return;
        const Rgb value = camera.throughput(row) * emitted;
        camera.record().arrive(row, camera.record().events().emission(), {0, path.depth + 2}, {value, emitted, value});
    }
    void add(std::uint32_t row, std::uint32_t light, const Rgb& emitted, Real light_pdf) {
        const Subpath& path = camera.path(row);
        if (path.depth < self.parameters_.first_depth) return;
        const bool sampled_too = self.sampled_too(path, light_pdf);
        Real weight = 1;
        if (sampled_too)
            weight = self.parameters_.strategy == PathStrategy::light ? 0.0f : power_heuristic(path.pdf, light_pdf);
        if (!(weight > 0)) return;
        const Rgb value = camera.throughput(row) * emitted;
        camera.record().arrive(row, camera.record().events().terminal(light), {0, path.depth + 2},
                               {value * weight, emitted, value, 1, sampled_too});
    }
    void arrives(std::size_t j) {
        if (camera.record().wants_blocked_light()) camera.report_hidden_environments(self.lights_[LiveLights::all], j);
    }
};

void PathIntegrator::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<PathThread&>(state);
    CameraSubpaths& camera = thread.camera;
    Ends ends{{}, *this, camera};
    camera.begin(batch.rays, batch.samplers, services.lpe, thread.counters);
    if (!batch.weights.empty()) camera.weigh(batch.weights);
    while (camera.going() && !services.leaving()) {
        camera.advance(services.display, ends);
        write_first_hits(context_, camera.vertices(), camera.first_entries(), thread.first_hits, services.display);
        if (splits_.any() || watch_ != nullptr)
            for (std::size_t j = 0; j < camera.vertices().count; ++j) camera.split(j);
        if (can_sample_lights_) {
            camera.draw_light_pairs();
            for (std::size_t j = 0; j < camera.vertices().count; ++j) sample_light(thread, j);
        }
        thread.connections.report(camera, thread.counters);
        camera.scatter();
    }
}

void PathIntegrator::sample_light(PathThread& thread, std::size_t j) const {
    CameraSubpaths& camera = thread.camera;
    if (!camera.can_connect(j)) return;
    const SurfacePoint& point = camera.vertices().points[j];
    const std::uint32_t row = camera.vertices().rows[j];
    std::uint8_t lights = LiveLights::all;
    TechniqueShares shares;
    if (!camera.record().takes_all(row)) {
        const display::Foresight::Ahead ahead =
            camera.record().ahead(row, camera.vertices().sources[j].label, point.material);
        lights = lights_.of(ahead);
        if (!ahead.scatters && lights != LiveLights::none) shares = at_last_;
        camera.choose_techniques(row, lights, shares.light, shares.ray);
    }
    if (lights == LiveLights::none) return thread.counters.count(Pruned::light_samples);
    if (shares.light < 1 &&
        !(camera.sampler(row).get_random(light_technique_dimensions + camera.path(row).depth) < shares.light))
        return thread.counters.count(Pruned::light_samples_left_to_rays);
    LightSample sample;
    if (!draw_light_sample(context_.scene, lights_[lights], camera, j, sample)) return;
    sample.pdf *= shares.light;
    if (parameters_.strategy == PathStrategy::scattering && !sample.delta) return;
    const BsdfEvaluation f = camera.vertices().bsdfs[j].evaluate(point.wo, sample.wi);
    if (f.value.is_black()) return;
    Real weight = 1;
    if (!sample.delta && parameters_.strategy == PathStrategy::mis)
        weight = power_heuristic(sample.pdf, shares.ray * static_cast<Real>(camera.path(row).rays) * f.pdf);
    thread.connections.add_light_sample(camera, j, sample, f, weight);
}

Result<std::unique_ptr<Integrator>> make_path(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    PathParameters p;
    auto depth = read_max_depth(entity, max_depth);
    if (!depth) return depth.error();
    p.max_depth = *depth;
    const std::vector<std::string> names = {"mis", "light", "scattering"};
    auto strategy = entity.parameters.choice_or("strategy", "mis", names);
    if (!strategy) return strategy.error();
    p.strategy = static_cast<PathStrategy>(std::find(names.begin(), names.end(), *strategy) - names.begin());
    auto roulette = read_roulette(entity);
    if (!roulette) return roulette.error();
    p.roulette_below = *roulette;
    auto splits = entity.parameters.boolean_or("splits", true);
    if (!splits) return splits.error();
    p.splits = *splits;
    auto channel_roulette = entity.parameters.boolean_or("channelroulette", true);
    if (!channel_roulette) return channel_roulette.error();
    p.channel_roulette = *channel_roulette;
    auto regularize = entity.parameters.boolean_or("regularize", false);
    if (!regularize) return regularize.error();
    p.regularize = *regularize;
    // pbrt's "exhaustive" is its bvh without the tree, for reference.
    auto selection = entity.parameters.choice_or("lightsampler", "bvh", {"power", "uniform", "bvh", "exhaustive"});
    if (!selection) return selection.error();
    p.light_selection = *selection == "uniform" ? LightSelection::uniform
                        : *selection == "power" ? LightSelection::power
                                                : LightSelection::receiver;
    return make_path_integrator(p);
}

}  // namespace

std::unique_ptr<Integrator> make_path_integrator(const PathParameters& parameters) {
    return std::make_unique<PathIntegrator>(parameters);
}

Registry<IntegratorFactory>::Entry path_integrator_entry() {
    using T = ParameterType;
    return {
        "path",
        "path tracing with light sampling, multiple importance sampling and Russian roulette",
        {{"maxdepth", T::integer, "5", "scattering events at most; emission seen after the last still counts"},
         {"strategy", T::string, "mis", "how emitters are found: mis, light or scattering"},
         describe_roulette("paths"),
         describe_roulette_threshold(),
         {"splits", T::boolean, "true",
          "without beauty: follow several rays from a path's first diffuse or glossy vertex, and both lobes of glass "
          "behind it, where a pilot says that it pays"},
         {"channelroulette", T::boolean, "true",
          "without beauty: end paths at random by what the channels may still receive of them, where a pilot says that "
          "it pays"},
         {"regularize", T::boolean, "false",
          "blur glossy and specular lobes behind a scattering that is not specular, as pbrt does: biased, and caustics "
          "become easier to find"},
         {"lightsampler", T::string, "bvh",
          "which light a sample goes to: bvh, by what each can send to the point where more than 32 stand somewhere "
          "and by power else; power; uniform; exhaustive of pbrt is bvh here"}},
        make_path};
}

}  // namespace raylex::transport
