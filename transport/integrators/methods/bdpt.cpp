#include "transport/integrators/methods/bdpt.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "transport/integrators/methods/path.h"
#include "transport/paths/subpaths/direct_light.h"
#include "transport/paths/subpaths/light_subpaths.h"

namespace raylex::transport {
namespace {

/// A light subpath's vertex, kept for the camera subpath of its row.
struct LightVertex : LightSubpathVertex {
    static constexpr std::uint32_t none = 0xffffffffu;
    SurfacePoint point;
    Bsdf bsdf;
    std::uint32_t previous = none;  ///< of the same subpath
};

/// Memory of a thread for the vertices of the light subpaths of a batch, which wait for camera subpaths. A light
/// subpath is cut when it has used its share, after some 2,300 scatterings, those inside bodies included.
constexpr std::size_t light_vertices_budget = std::size_t{256} << 20;

struct BdptThread final : IntegratorThread {
    BdptThread(const PathContext& context, const LightEmitters& emitters, const WalkOptions& of_light,
               const WalkOptions& of_camera)
        : IntegratorThread(of_camera.max_depth),
          light(context, emitters, of_light),
          camera(context, of_camera),
          connections(context.scene),
          splats(context),
          last_vertex(static_cast<std::size_t>(context.batch_capacity)) {}

    LightSubpaths light;
    CameraSubpaths camera;
    Connections connections;  // s >= 1
    CameraConnections splats;
    std::vector<LightVertex> light_vertices;  // of all rows
    std::vector<std::uint32_t> last_vertex;   // by row, in light_vertices
};

class Bdpt final : public Integrator {
  public:
    explicit Bdpt(const BdptParameters& parameters) : parameters_(parameters) {}
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.emitter_samples = traits.light_samples = traits.holdouts = traits.user_events = true;
        traits.media = traits.first_hits = traits.cutouts = true;
        // As many mirrors may come first.
        traits.max_depth = std::uint64_t{parameters_.depth.max_depth} * (parameters_.count_mirrors ? 1 : 2);
        traits.saved_state = SavedState::none;
        traits.raster_splats = traits.pixel_samples = true;
        return traits;
    }
    /// A guide of camera subpaths learns from paths of `path`: other strategies change what is left for a direction to
    /// find, but not where light comes from.
    [[nodiscard]] GuideRequest guide_request() const override {
        GuideRequest request = parameters_.guide;
        PathParameters path;
        path.max_depth = parameters_.depth.max_depth;
        path.roulette_below = parameters_.depth.roulette_below;
        request.make_trial = [path] { return make_path_integrator(path); };
        return request;
    }
    Status prepare(const IntegratorContext& context) override {
        context_ = context;
        emitters_ = LightEmitters(context_, parameters_.depth.max_depth);
        direct_light_ = DirectLight(context_, emitters_.language());
        return success();
    }
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override {
        const WalkOptions options{.max_depth = parameters_.depth.max_depth,
                                  .roulette_below = parameters_.depth.roulette_below,
                                  .densities = true,
                                  .counts_first_specular = parameters_.count_mirrors,
                                  .most_scatterings = most_scatterings(),
                                  .sampled = &direct_light_.chooser()};
        WalkOptions of_camera = options;
        of_camera.first_depth = parameters_.first_depth;
        return std::make_unique<BdptThread>(context_, emitters_, options, of_camera);
    }
    [[nodiscard]] std::vector<std::string> cuts() const override {
        if (cut_light_subpaths_ == 0) return {};
        return {std::to_string(cut_light_subpaths_) + " light subpaths were cut after " +
                std::to_string(most_scatterings()) +
                " scatterings, because bdpt keeps their vertices: light of longer "
                "ones is missing"};
    }
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    [[nodiscard]] std::uint32_t most_scatterings() const {
        return static_cast<std::uint32_t>(light_vertices_budget /
                                          (static_cast<std::size_t>(context_.batch_capacity) * sizeof(LightVertex)));
    }
    void keep_light_vertices(BdptThread& thread) const;
    void report_lights(CameraSubpaths& camera) const;
    void report(const CameraSubpaths& camera, std::uint32_t row, const Rgb& throughput, const Rgb& emitted,
                const LightSample& at, Real light_pdf, const Vec3& towards) const;
    [[nodiscard]] Real weight_of_light_sample(const CameraSubpaths& camera, std::size_t j, const LightSample& sample,
                                              const BsdfEvaluation& f) const;
    void connect_vertices(BdptThread& thread, std::size_t j) const;

    BdptParameters parameters_;
    IntegratorContext context_;
    LightEmitters emitters_;
    DirectLight direct_light_;
    mutable std::atomic<std::uint64_t> cut_light_subpaths_{0};
};

void Bdpt::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<BdptThread&>(state);
    CameraSubpaths& camera = thread.camera;
    thread.light_vertices.clear();
    std::fill_n(thread.last_vertex.begin(), batch.rays.size(), LightVertex::none);
    thread.light.begin(batch, services, thread.counters);
    while (thread.light.advance(services)) {
        keep_light_vertices(thread);
        thread.light.scatter();
    }
    if (services.left) return;
    if (thread.light.cut() > 0) cut_light_subpaths_ += thread.light.cut();
    camera.begin(batch, services, thread.counters);
    while (camera.advance(services)) {
        report_lights(camera);
        direct_light_.report_hidden_environments(camera);
        direct_light_.sample(camera, thread.connections,
                             [&](std::size_t j, const LightSample& sample, const BsdfEvaluation& f) {
                                 return weight_of_light_sample(camera, j, sample, f);
                             });
        for (std::size_t j = 0; j < camera.vertices().count; ++j) connect_vertices(thread, j);
        thread.connections.report(camera);
        camera.scatter();
    }
    if (services.left) return;
    for (const LightVertex& y : thread.light_vertices) {  // t = 1
        const Rgb power = y.one_wavelength ? y.power * thread.light.wavelength_weight(y.row) : y.power;
        thread.splats.add(y, y.point, y.bsdf, power, thread.light.depth_limit(), batch.samplers[y.row],
                          thread.counters);
    }
    thread.splats.splat(batch.rows, services, thread.counters);
    for (const InvalidPower& each : thread.light.invalid_powers())
        reject_power(services, batch.rows[each.row], each.power);
}

void Bdpt::keep_light_vertices(BdptThread& thread) const {
    const VertexBatch& v = thread.light.vertices();
    for (std::size_t j = 0; j < v.count; ++j) {
        if (!v.bsdfs[j].has_density()) continue;
        const auto index = static_cast<std::uint32_t>(thread.light_vertices.size());
        std::uint32_t& last = thread.last_vertex[v.rows[j]];
        thread.light_vertices.push_back({thread.light.vertex(j), v.points[j], v.bsdfs[j], last});
        if (thread.light_vertices.back().live.connects) last = index;
    }
}

/// s = 0: lights that camera subpaths have met by themselves.
void Bdpt::report_lights(CameraSubpaths& camera) const {
    const SceneView& scene = context_.scene;
    const LightTable& lights = *scene.lights;
    for (const EscapedRay& e : camera.escaped()) {
        const Subpath& path = camera.path(e.row);
        camera.mis_weights(e.row).arrive(path.specular ? 1 : path.pdf, 1);
        for (const std::uint32_t light : lights.environments()) {
            LightSample at;
            at.light = light;
            at.infinite = true;
            at.wi = e.direction;
            report(camera, e.row, camera.throughput(e.row), lights.environment_radiance(light, path.from, e.direction),
                   at, lights.environment_density(direct_light_.chooser(), light, path.from, e.direction),
                   -e.direction);
        }
    }
    for (const EmitterHit& e : camera.emitters()) {
        const Subpath& path = camera.path(e.row);
        LightSample at;
        at.light = e.light;
        at.target = e.point.position;
        at.target_normal = e.point.geometric_normal;
        at.uv = {e.hit.u, e.hit.v};
        const Real light_pdf =
            path.depth > 0 ? lights.density(direct_light_.chooser(), *scene.geometry, path.from, at) : 0;
        report(camera, e.row, e.throughput, e.emitted, at, light_pdf, e.point.wo);
    }
}

/// `light_pdf`: the density with which a light sample finds the light. Light leaves `at` in the direction `towards`.
/// The weight is Georgiev's (2012, equation 43).
void Bdpt::report(const CameraSubpaths& camera, std::uint32_t row, const Rgb& throughput, const Rgb& emitted,
                  const LightSample& at, Real light_pdf, const Vec3& towards) const {
    if ((throughput * emitted).is_black()) return;
    const Subpath& path = camera.path(row);
    Real weight = 1;
    if (path.depth > 0) {  // no other strategy finds what the camera sees directly
        EmissionDensity emission;
        if (emitters_.any())
            emission =
                context_.scene.lights->emission_density(emitters_.chooser(), *context_.scene.geometry, at, towards);
        const double pdf = path.specular ? 1 : path.pdf;
        weight = PartialMisWeights::weight(
            camera.mis_weights(row).others_at_light(light_pdf / pdf, emission.position, emission.direction));
    }
    camera.report(row, at.light, throughput, emitted, weight, !path.specular && light_pdf > 0);
}

/// s = 1. The other strategies: the camera subpath meets the light by itself (Georgiev 2012, equation 44), or light
/// subpaths begin there (equation 45).
Real Bdpt::weight_of_light_sample(const CameraSubpaths& camera, std::size_t j, const LightSample& sample,
                                  const BsdfEvaluation& f) const {
    const VertexBatch& v = camera.vertices();
    const SurfacePoint& point = v.points[j];
    const LightTable& lights = *context_.scene.lights;
    const Light& light = lights.lights()[sample.light];
    const double pdf = sample.pdf;
    const double met = light.is_delta() ? 0 : PartialMisWeights::squared(f.pdf / pdf);
    if (!emitters_.any()) return PartialMisWeights::weight(met);
    const EmissionDensity emission =
        lights.emission_density(emitters_.chooser(), *context_.scene.geometry, sample, -sample.wi);
    const double near = sample.infinite ? 1 : 1.0 / length_squared(sample.target - point.position);
    const double light_cosine = light.is_area() ? std::abs(dot(sample.target_normal, sample.wi)) : 1;
    const double to_light = light.is_area() ? light_cosine * near : 1;
    const double begun = to_light > 0 ? emission.position / (pdf * to_light) : 0;
    const double cosine = point.cosine(sample.wi);
    const auto pdf_reverse =
        direction_density<TransportMode::importance>(context_.directions, v.bsdfs[j], point, sample.wi, point.wo);
    const double w_camera = PartialMisWeights::squared(begun) *
                            camera.mis_weights(v.rows[j]).others(emission.direction * cosine * near, pdf_reverse);
    return PartialMisWeights::weight(met + w_camera);
}

/// s, t >= 2: connects vertex j of the camera subpath with all vertices of the light subpath of its row.
void Bdpt::connect_vertices(BdptThread& thread, std::size_t j) const {
    CameraSubpaths& camera = thread.camera;
    const VertexBatch& v = camera.vertices();
    const std::uint32_t row = v.rows[j];
    if (thread.last_vertex[row] == LightVertex::none || !camera.can_connect(j) || !camera.needs_connections(j)) return;
    const Subpath& path = camera.path(row);
    const SurfacePoint& point = v.points[j];
    const DepthLimit& limit = camera.depth_limit();
    const VertexDepth length = camera.vertex_depth(j);
    for (std::uint32_t i = thread.last_vertex[row]; i != LightVertex::none; i = thread.light_vertices[i].previous) {
        const LightVertex& y = thread.light_vertices[i];
        if (!limit.allows(length.least + y.length.least)) continue;
        if (!thread.light.may_connect(camera, j, y, y.point.material)) continue;
        const Vec3 between = y.point.position - point.position;
        const Real d2 = length_squared(between);
        if (!(d2 > 0)) continue;
        const Vec3 direction = between / std::sqrt(d2);
        if (limit.has_bodies() && !limit.allows(length.before + limit.event(length, point, direction) +
                                                y.length.before + limit.event(y.length, y.point, -direction)))
            continue;
        const ConnectedScattering x =
            evaluate_scattering<TransportMode::radiance>(context_.directions, v.bsdfs[j], point, direction);
        if (x.f.value.is_black()) continue;
        const ConnectedScattering z =
            evaluate_scattering<TransportMode::importance>(context_.directions, y.bsdf, y.point, -direction);
        if (z.f.value.is_black()) continue;
        const double near = 1.0 / d2;
        const double at_camera = point.cosine(direction) * near, at_light = y.point.cosine(direction) * near;
        const double w_light = y.mis_weights.others(x.f.pdf * at_light, z.pdf_reverse);  // Georgiev 2012, equation 40
        const double w_camera = camera.mis_weights(row).others(z.f.pdf * at_camera, x.pdf_reverse);  // equation 41
        VertexConnection connection{.j = j, .f = &x.f, .end = y.end, .light_vertices = y.depth + 2};
        connection.end.lobes = z.f.lobes;
        connection.unweighted = path.beta * x.f.value * z.f.value * y.power * (1 / d2);
        if (path.one_wavelength || y.one_wavelength) connection.unweighted *= thread.light.wavelength_weight(row);
        connection.weight = PartialMisWeights::weight(w_camera + w_light);
        connection.shadow_ray =
            segment_to(offset_ray_origin(point.position, point.geometric_normal, v.sources[j].offset.here, direction),
                       y.point.position, y.point.geometric_normal, y.offset);
        thread.connections.add_connection(camera, connection);
    }
}

}  // namespace

std::unique_ptr<Integrator> make_bdpt_integrator(const BdptParameters& parameters) {
    return std::make_unique<Bdpt>(parameters);
}

Registry<IntegratorFactory>::Entry bdpt_entry() {
    std::vector<ParameterDescription> described = describe_depth_parameters("subpaths");
    described.push_back({"countmirrors", ParameterType::boolean, "true",
                         "false: ideal mirrors and glass that the camera sees first do not count towards maxdepth, so "
                         "that a mirror shows what is seen without it (pbrt's sppm)"});
    const std::vector<ParameterDescription> guide = describe_guide_parameters();
    described.insert(described.end(), guide.begin(), guide.end());
    return {
        "bdpt", "bidirectional path tracing: subpaths from camera and lights, connected at every vertex",
        std::move(described),
        [](const SceneEntity& entity, std::optional<std::int64_t> max_depth) -> Result<std::unique_ptr<Integrator>> {
            IntegratorParameters read(entity);
            BdptParameters parameters;
            parameters.depth = read_depth_parameters(read, max_depth);
            parameters.count_mirrors = read.boolean("countmirrors", true);
            parameters.guide = read_guide_parameters(read);
            if (read.error()) return *read.error();
            return make_bdpt_integrator(parameters);
        }};
}

}  // namespace raylex::transport
