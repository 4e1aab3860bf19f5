// A path tracer with one deliberate mistake, which the study experiments/studies/planted-error.toml must find. It
// samples lights at every surface and traces one ray at a time, so that the code is easy to read. Start your own
// integrator from this file: remove the mistake, add your idea, and judge it with the same experiment.
#include <array>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;
using raylex::transport::Rgb;  // in the double build, this type differs from display's

class PlantedError final : public Integrator {
  public:
    PlantedError(bool mistake, std::int64_t max_depth)
        : mistake_(mistake), max_depth_(static_cast<std::uint32_t>(max_depth)) {}

    Status prepare(const IntegratorContext& context) override { return context_ = context, success(); }
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.max_depth = max_depth_;
        traits.saved_state = SavedState::none;  // a sample depends only on its number
        return traits;
    }

    void integrate(const CameraBatch& camera, IntegratorThread& thread, ThreadServices& services) const override {
        for (std::size_t i = 0; i < camera.rays.size(); ++i)
            trace(camera.rays[i], camera.samplers[i], static_cast<int>(i), thread.counters, services);
        thread.counters.camera_rays += camera.rays.size();
    }

  private:
    static constexpr std::uint32_t dimensions = 8;  // random numbers per vertex
    static constexpr float survival = 0.75f;

    void trace(Ray ray, const PixelSampler& sampler, int row, IntegratorCounters& counters,
               ThreadServices& services) const {
        const SceneView& scene = context_.scene;
        display::Tracker path = services.lpe.begin(row);
        Rgb throughput(1);
        bool specular_bounce = true;  // light sampling cannot find the light that this ray finds
        for (std::uint32_t depth = 0;; ++depth) {
            const std::uint32_t first = first_free_dimension + dimensions * depth;
            Hit hit[1];
            SurfacePoint point[1];
            SurfaceSource source[1];
            scene.geometry->intersect({&ray, 1}, hit);
            if (!hit->valid()) {
                if (specular_bounce)
                    for (const std::uint32_t light : scene.lights->environments())
                        add(throughput * scene.lights->environment_radiance(light, ray.origin, ray.direction), light,
                            path, services);
                return;
            }
            scene.geometry->surfaces({&ray, 1}, hit, point, source);
            if (depth == 0) {
                services.display.write_distance(row, to_float(hit->t));
                services.display.write_opacity(row, 1.0f);
            }
            const ShapeGeometry& shape = scene.geometry->shapes()[hit->shape];
            if (specular_bounce && shape.first_light != Hit::none) {
                const std::uint32_t light = shape.first_light + hit->primitive;
                add(throughput * scene.lights->emitted(light, *point, point->wo), light, path, services);
            }
            if (depth == max_depth_) return;
            point->random_key = sampler.key(first);
            point->services = {&services.display, row, depth};
            Bsdf bsdf[1];
            scene.materials->shade(*scene.textures, point, bsdf);
            sample_light(*point, *source, *bsdf, ray.time, throughput, path, sampler, first, counters, services);

            // Russian roulette from the second scattering event on. The mistake: a surviving path must be divided by
            // the survival probability. Without the division, every path with three or more scattering events is too
            // dark.
            if (depth >= 1) {
                if (sampler.get_random(first + 1) >= survival) return;
                if (!mistake_) throughput *= 1 / survival;
            }
            const BsdfSample s = bsdf->sample(point->wo, sampler.get_1d(first + 2), sampler.get_2d(first + 3));
            if (!(s.pdf > 0) || s.weight.is_black()) return;
            throughput *= s.weight;
            specular_bounce = s.delta;
            move(path, *source, s.lobes, services);
            if (!services.lpe.live(path)) return;
            const Real time = ray.time;
            ray = Ray();
            ray.time = time;
            ray.origin = offset_ray_origin(point->position, point->geometric_normal, source->offset.here, s.wi);
            ray.direction = s.wi;
            ++counters.scattering_rays;
        }
    }

    void sample_light(const SurfacePoint& point, const SurfaceSource& source, const Bsdf& bsdf, Real time,
                      const Rgb& throughput, display::Tracker path, const PixelSampler& sampler, std::uint32_t first,
                      IntegratorCounters& counters, ThreadServices& services) const {
        const SceneView& scene = context_.scene;
        LightSample sample;
        if (!bsdf.has_density() || scene.lights->chooser(LightChoice::light_sampling).empty() ||
            !scene.lights->sample(scene.lights->chooser(LightChoice::light_sampling), *scene.geometry, point.position,
                                  sampler.get_1d(first + 5), sampler.get_2d(first + 6), sample))
            return;
        const BsdfEvaluation f = bsdf.evaluate(point.wo, sample.wi);
        if (f.value.is_black()) return;
        Ray shadow = shadow_ray(point.position, point.geometric_normal, source.offset.here, sample);
        shadow.time = time;
        std::uint8_t blocked[1];
        scene.geometry->occluded({&shadow, 1}, blocked);
        ++counters.shadow_rays;
        if (*blocked) return;
        move(path, source, f.lobes, services);
        add(throughput * f.value * sample.radiance * (1 / sample.pdf), sample.light, path, services);
    }

    /// Moves one step along the path: each lobe's event with its part of the value (Law 5).
    void move(display::Tracker& path, const SurfaceSource& source, const LobeList& lobes,
              ThreadServices& services) const {
        std::array<display::LobePart, max_lobes> parts;
        const auto count = static_cast<std::size_t>(lobes.count);
        for (std::size_t i = 0; i < count; ++i)
            parts[i] = {context_.events->scatter(source.label, lobes.entry[i].lobe), to_float(lobes.entry[i].value)};
        services.lpe.move(path, {parts.data(), count});
    }

    void add(const Rgb& value, std::uint32_t light, display::Tracker path, ThreadServices& services) const {
        services.lpe.move(path, context_.events->terminal(light));
        services.lpe.contribute(to_float(value), display::Technique{1, 2}, path);
    }

    bool mistake_;
    std::uint32_t max_depth_;
    IntegratorContext context_;
};

Result<std::unique_ptr<Integrator>> make_planted_error(const SceneEntity& entity,
                                                       std::optional<std::int64_t> max_depth) {
    ParameterReader reader(entity.parameters);
    const bool mistake = reader.boolean("mistake", true);
    const int depth = reader.integer("maxdepth", 5, 0, 1000);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Integrator>(std::make_unique<PlantedError>(mistake, max_depth.value_or(depth)));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_integrator({"plantederror",
                         "a path tracer by light sampling that forgets to divide by the survival probability",
                         {{"mistake", ParameterType::boolean, "true", "false: the integrator without the mistake"},
                          {"maxdepth", ParameterType::integer, "5", "maximum number of scattering events of a path"}},
                         make_planted_error});
}
