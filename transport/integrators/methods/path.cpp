#include "transport/integrators/methods/path.h"

#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

struct PathThread final : IntegratorThread {
    PathThread(const PathContext& context, const WalkOptions& options)
        : IntegratorThread(options.max_depth), camera(context, options), connections(context.scene) {}
    CameraSubpaths camera;
    Connections connections;
};

class PathIntegrator final : public Integrator {
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
    [[nodiscard]] PlanRequest plan_request() const override {
        if (parameters_.strategy != PathStrategy::mis || parameters_.max_depth == 0) return {};
        return {.make_trial = [p = parameters_] { return make_path_integrator(p); },
                .light_choice = light_choice(parameters_.light_selection, parameters_.strategy),
                .lights_by_receiver = parameters_.light_selection == LightSelection::receiver,
                .splits = parameters_.splits,
                .roulette = parameters_.channel_roulette,
                .roulette_below = parameters_.roulette_below};
    }
    [[nodiscard]] GuideRequest guide_request() const override {
        if (parameters_.max_depth == 0) return {};
        GuideRequest request = parameters_.guide;
        request.make_trial = [p = parameters_] { return make_path_integrator(p); };
        return request;
    }
    Status prepare(const IntegratorContext& context) override {
        context_ = context;
        direct_light_ = DirectLight(context_, parameters_.light_selection, parameters_.strategy);
        return success();
    }
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override {
        return std::make_unique<PathThread>(context_, parameters_);
    }
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    PathParameters parameters_;
    IntegratorContext context_;
    DirectLight direct_light_;
};

void PathIntegrator::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<PathThread&>(state);
    CameraSubpaths& camera = thread.camera;
    const LightTable& lights = *context_.scene.lights;
    // `light_pdf`: of a light sample at the vertex before, for the same direction; 0 where it cannot find the emitter.
    const auto report = [&](std::uint32_t row, std::uint32_t light, const Rgb& throughput, const Rgb& emitted,
                            Real light_pdf) {
        Real weight = 1;
        if (light_pdf > 0)  // Veach 1997, equation 9.13
            weight = parameters_.strategy == PathStrategy::light ? 0 : power_heuristic(camera.path(row).pdf, light_pdf);
        if (weight > 0) camera.report(row, light, throughput, emitted, weight, light_pdf > 0);
    };
    camera.begin(batch, services, thread.counters);
    while (camera.advance(services)) {
        // densities of light samples are those of the vertex before, until sample() sets new ones
        for (const EscapedRay& e : camera.escaped())
            for (const std::uint32_t light : lights.environments())
                report(e.row, light, camera.throughput(e.row),
                       lights.environment_radiance(light, camera.path(e.row).from, e.direction),
                       direct_light_.density(camera, e, light));
        for (const EmitterHit& e : camera.emitters())
            report(e.row, e.light, e.throughput, e.emitted, direct_light_.density(camera, e));
        direct_light_.report_hidden_environments(camera);
        direct_light_.sample(camera, thread.connections,
                             [&](std::size_t j, const LightSample& sample, const BsdfEvaluation& f) {
                                 if (sample.delta || parameters_.strategy != PathStrategy::mis) return Real(1);
                                 // The walk multiplies path.pdf by the same factor once the ray is drawn.
                                 const Real rays = camera.expected_rays(j);
                                 return power_heuristic(sample.pdf, rays * f.pdf);  // Veach 1997, equation 9.13
                             });
        thread.connections.report(camera);
        camera.scatter();
    }
}

Result<std::unique_ptr<Integrator>> make_path(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    IntegratorParameters read(entity);
    PathParameters p;
    p.max_depth = read.max_depth(max_depth);
    p.strategy = static_cast<PathStrategy>(read.choice("strategy", {"mis", "light", "scattering"}, 0));
    p.roulette_below = read.roulette_below();
    p.splits = read.boolean("splits", true);
    p.channel_roulette = read.boolean("channelroulette", true);
    p.regularize = read.boolean("regularize", false);
    // pbrt's "exhaustive" weighs every light one by one, for reference. Here it means bvh.
    constexpr std::array<LightSelection, 4> selections{LightSelection::power, LightSelection::uniform,
                                                       LightSelection::receiver, LightSelection::receiver};
    p.guide = read_guide_parameters(read);
    p.guide.gain = read.choice("guideroulette", {"gain", "throughput"}, 0) == 0 && p.roulette_below > 0;
    p.light_selection = selections[read.choice("lightsampler", {"power", "uniform", "bvh", "exhaustive"}, 2)];
    if (read.error()) return *read.error();
    return make_path_integrator(p);
}

}  // namespace

std::unique_ptr<Integrator> make_path_integrator(const PathParameters& parameters) {
    return std::make_unique<PathIntegrator>(parameters);
}

Registry<IntegratorFactory>::Entry path_integrator_entry() {
    using T = ParameterType;
    std::vector<ParameterDescription> described{
        describe_max_depth(),
        {"strategy", T::string, "mis", "how emitters are found: mis, light or scattering"},
        describe_roulette("paths"),
        describe_roulette_threshold(),
        {"splits", T::boolean, "true",
         "without beauty: follow several rays from a path's first diffuse or glossy vertex, and both lobes of "
         "glass behind it, where trials before the render show that it pays"},
        {"channelroulette", T::boolean, "true",
         "without beauty: end paths at random by what the channels still expect of them, where trials before "
         "the render show that it pays"},
        {"regularize", T::boolean, "false",
         "blur glossy and specular lobes behind a scattering that is not specular, as pbrt does: biased, and "
         "caustics become easier to find"},
        {"lightsampler", T::string, "bvh",
         "how a light sample chooses its light: bvh, by what each light can send to the point where more than 32 "
         "lights have a position, else by power; power; uniform; exhaustive of pbrt is bvh here"}};
    const std::vector<ParameterDescription> guide = describe_guide_parameters();
    described.insert(described.end(), guide.begin(), guide.end());
    described.push_back({"guideroulette", T::string, "gain",
                         "what ends guided paths at random: gain, by the light and the cost that the training "
                         "expects behind a vertex, which also splits paths; throughput"});
    return {"path", "path tracing with light sampling, multiple importance sampling and Russian roulette",
            std::move(described), make_path};
}

}  // namespace raylex::transport
