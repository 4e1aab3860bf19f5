// @NAME@: a path tracer with light sampling that uses every call of the display services. Start from here.
//
// It traces one ray at a time, so that the code is easy to read. Light path expressions, deep images, cryptomattes and
// AOVs need no further code: the integrator reports its light and does not depend on the requested layers.
#include <array>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;
using raylex::transport::Rgb;

class PathTracer final : public Integrator {
  public:
    explicit PathTracer(std::uint32_t max_depth) : max_depth_(max_depth) {}

    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.max_depth = max_depth_;
        traits.saved_state = SavedState::none;  // a sample depends only on its number, so renders can be resumed
        // first_hits stays false: the renderer writes geometric AOVs. cutouts stays false: this integrator treats them
        // as opaque.
        return traits;
    }
    Status prepare(const IntegratorContext& context) override { return context_ = context, success(); }

    void integrate(const CameraBatch& camera, IntegratorThread& thread, ThreadServices& services) const override {
        // GetDisplayChannels: the channels of this render. A channel that was not requested has the id invalid_channel;
        // calls may write to it without effect.
        const auto channels = services.display.get_display_channels();
        const display::ChannelId bounces = display::find_channel(channels, "@NAME@_bounces"),
                                 glow = display::find_channel(channels, "@NAME@_glow"),
                                 glow_again = display::find_channel(channels, "@NAME@_glow_again");
        for (std::size_t i = 0; i < camera.rays.size(); ++i) {
            const int row = static_cast<int>(i);
            const Seen seen = trace(camera.rays[i], camera.samplers[i], row, thread.counters, services);
            services.display.write(bounces, row, seen.bounces);  // Write: replaces the value of the row
            services.display.splat(glow, row, seen.glow);        // Splat: adds to the row
            const std::array both{glow, glow_again};
            services.display.splat_multi(both, row, seen.glow);  // SplatMulti: adds to several channels
        }
        thread.counters.camera_rays += camera.rays.size();
        // DiscardIteration: drops everything that this call sent, such as the samples of a warm-up.
        if (camera.startup) services.display.discard_iteration();
    }

  private:
    struct Seen {
        float bounces = 0;
        raylex::Rgb glow;  ///< light of emitters that the camera sees directly
    };
    static constexpr std::uint32_t dimensions = 8;  // random numbers per vertex
    static constexpr float survival = 0.75f;        // survival probability from the second scattering event on

    Seen trace(Ray ray, const PixelSampler& sampler, int row, IntegratorCounters& counters,
               ThreadServices& services) const {
        const SceneView& scene = context_.scene;
        display::Tracker path = services.lpe.begin(row);
        Rgb throughput(1);
        Seen seen;
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
                        add(throughput * scene.lights->environment_radiance(light, ray.origin, ray.direction), light, 1,
                            path, services);
                return seen;
            }
            scene.geometry->surfaces({&ray, 1}, hit, point, source);
            if (depth == 0) report_first_hit(*hit, row, services.display);
            const ShapeGeometry& shape = scene.geometry->shapes()[hit->shape];
            if (specular_bounce && shape.first_light != Hit::none) {
                const std::uint32_t light = shape.first_light + hit->primitive;
                const Rgb emitted = scene.lights->emitted(light, *point, point->wo);
                if (depth == 0) seen.glow = to_float(emitted);
                add(throughput * emitted, light, depth + 1, path, services);
            }
            if (depth == max_depth_) return seen;
            point->random_key = sampler.key(first);
            point->services = {&services.display, row, depth};  // for patterns and materials that write to channels
            Bsdf bsdf[1];
            scene.materials->shade(*scene.textures, point, bsdf);
            sample_light(*point, *source, *bsdf, ray.time, throughput, path, sampler, first, counters, services);

            if (depth >= 1) {
                if (sampler.get_random(first + 1) >= survival) return seen;
                throughput *= 1 / survival;
            }
            const BsdfSample s = bsdf->sample(point->wo, sampler.get_1d(first + 2), sampler.get_2d(first + 3));
            if (!(s.pdf > 0) || s.weight.is_black()) return seen;
            throughput *= s.weight;
            specular_bounce = s.delta;
            seen.bounces += 1;
            move(path, *source, s.lobes, services);
            if (!services.lpe.live(path)) return seen;  // no layer can accept the rest of the path
            const Real time = ray.time;
            ray = Ray();
            ray.time = time;
            ray.origin = offset_ray_origin(point->position, point->geometric_normal, source->offset.here, s.wi);
            ray.direction = s.wi;
            ++counters.scattering_rays;
        }
    }

    /// WriteDistance and opacity of the camera ray. AddSample adds a row to the same ray, here a transparent veil
    /// before the surface. Deep images, alpha and mattes use all rows of a ray.
    void report_first_hit(const Hit& hit, int row, display::DisplayServices& display) const {
        display.write_distance(row, to_float(hit.t));
        display.write_opacity(row, 1.0f);
        display.write_surface(row, context_.scene.geometry->surface_number(hit));
        display.add_sample(row, {.depth = to_float(hit.t) / 2, .opacity = RgbD(0.0), .is_volume = true});
    }

    void sample_light(const SurfacePoint& point, const SurfaceSource& source, const Bsdf& bsdf, Real time,
                      const Rgb& throughput, display::Tracker path, const PixelSampler& sampler, std::uint32_t first,
                      IntegratorCounters& counters, ThreadServices& services) const {
        const SceneView& scene = context_.scene;
        const LightChooser& lights = scene.lights->chooser(LightChoice::light_sampling);
        LightSample sample;
        if (!bsdf.has_density() || lights.empty() ||
            !scene.lights->sample(lights, *scene.geometry, point.position, sampler.get_1d(first + 5),
                                  sampler.get_2d(first + 6), sample))
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
        add(throughput * f.value * sample.radiance * (1 / sample.pdf), sample.light, 2, path, services);
    }

    /// Moves one step along the path: each lobe's event with its part of the value, so that layers by lobe sum exactly.
    void move(display::Tracker& path, const SurfaceSource& source, const LobeList& lobes,
              ThreadServices& services) const {
        std::array<display::LobePart, max_lobes> parts;
        const auto count = static_cast<std::size_t>(lobes.count);
        for (std::size_t i = 0; i < count; ++i)
            parts[i] = {context_.events->scatter(source.label, lobes.entry[i].lobe), to_float(lobes.entry[i].value)};
        services.lpe.move(path, {parts.data(), count});
    }

    /// Reports light to the LPE services once. The beauty and every layer whose expression accepts the path receive it.
    void add(const Rgb& value, std::uint32_t light, std::uint32_t camera_vertices, display::Tracker path,
             ThreadServices& services) const {
        services.lpe.move(path, context_.events->terminal(light));
        services.lpe.contribute(to_float(value), display::Technique{1, camera_vertices}, path);
    }

    std::uint32_t max_depth_;
    IntegratorContext context_;
};

Result<std::unique_ptr<Integrator>> make(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    ParameterReader reader(entity.parameters);
    const int depth = reader.integer("maxdepth", 5, 0, 1000);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Integrator>(
        std::make_unique<PathTracer>(static_cast<std::uint32_t>(max_depth.value_or(depth))));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_integrator({"@NAME@",
                         "a path tracer with light sampling",
                         {{"maxdepth", ParameterType::integer, "5", "maximum number of scattering events of a path"}},
                         make});
    host.add_channel(display::declared_channel("@NAME@_bounces", display::ChannelType::real),
                     "number of scattering events of a path");
    host.add_channel(display::declared_channel("@NAME@_glow", display::ChannelType::rgb),
                     "light of directly visible emitters, doubled");
    host.add_channel(display::declared_channel("@NAME@_glow_again", display::ChannelType::rgb),
                     "light of directly visible emitters");
}
