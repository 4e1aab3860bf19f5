#include "transport/paths/subpaths/light_subpaths.h"

#include <cmath>

#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

LightSubpaths::LightSubpaths(const SceneView& scene, const EventTable& events, const LightSubpathOptions& options,
                             std::size_t capacity)
    : scene_(scene),
      options_(options),
      walk_(scene, events, options.walk, capacity),
      record_(events, options.language, capacity) {
    if (options.walk.densities) origins_.resize(capacity);
}

void LightSubpaths::begin(std::span<const Ray> camera_rays, std::span<const PixelSampler> samplers,
                          display::LpeServices& lpe, IntegratorCounters& counters) {
    walk_.begin(samplers, counters);
    record_.begin(lpe);
    const LightTable& lights = *scene_.lights;
    const LightChooser& emitters = *options_.emitters;
    const bool own_choice = emitters.needs_number();
    for (std::size_t i = 0; i < samplers.size(); ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        const PixelSampler& sampler = samplers[i];
        walk_.path(row) = Subpath();
        EmissionSample s;
        if (lights.sample_emission(emitters, *scene_.geometry,
                                   own_choice ? sampler.get_1d(light_dimensions + emitter_dimension) : 0.0f,
                                   sampler.get_2d(light_dimensions + origin_dimension),
                                   sampler.get_2d(light_dimensions + direction_dimension), s))
            start(row, s, camera_rays[i].time);
        else counters.count_length(0);
    }
}

void LightSubpaths::start(std::uint32_t row, const EmissionSample& s, Real time) {
    Subpath& path = walk_.path(row);
    const Light& light = scene_.lights->lights()[s.from.light];
    Rgb power = s.power;
    if (!s.from.infinite) power *= emitter_opacity(scene_, s.from, s.from.target + s.direction);
    if (!options_.media_of_lights.empty()) {
        path.medium = options_.media_of_lights[s.from.light];
        if (light.is_area())
            path.medium =
                scene_.geometry->shapes()[light.shape].medium_towards(s.from.target_normal, s.direction, path.medium);
        else if (s.from.infinite && path.medium >= 0) power *= from_infinity(row, s);
    }
    path.beta = power;
    path.roulette_scale = power.max();
    path.light = s.from.light;
    path.specular = false;
    path.from = light.is_area() ? s.from.target : s.origin;
    record_.leave_light(row, s.from.light);
    if (power.is_black() || !worth(row)) return walk_.finish(row);
    if (options_.walk.densities) {
        const EmissionDensity density =
            scene_.lights->emission_density(*options_.emitters, *scene_.geometry, s.from, s.direction);
        path.pdf = density.direction;
        path.cosine = light.is_area() ? std::abs(dot(s.from.target_normal, s.direction)) : 1;
        path.from_infinity = s.from.infinite;
        origins_[row] = s.from;
        StrategySums& sums = walk_.sums(row);
        sums = StrategySums();
        sums.previous = static_cast<double>(density.position);
        sums.tail = light.is_delta() ? 0 : 1;  // camera subpaths find what is not a delta light by themselves
    }
    Ray ray;
    ray.origin = s.origin;
    ray.direction = s.direction;
    ray.time = time;
    walk_.push(row, ray);
}

/// What the medium lets pass of light that comes from infinitely far away to where its ray begins.
Rgb LightSubpaths::from_infinity(std::uint32_t row, const EmissionSample& s) const {
    const Medium& medium = (*scene_.media)[walk_.path(row).medium];
    if (medium.grid == nullptr) return transmittance(medium, infinity);
    const FlightNumbers numbers(walk_.sampler(row).key(Walk<TransportMode::importance>::dimensions.connections), 1);
    return medium.grid->transmittance({s.origin, -s.direction, infinity}, numbers);
}

struct LightSubpaths::Visitor : WalkVisitor {
    LightSubpaths& self;

    /// Whether a subpath out of a portal's sky has come through the portal: before that its light is nobody's.
    [[nodiscard]] bool is_in(std::uint32_t row, const Vec3& point, const Vec3& forward) const {
        const Subpath& path = self.path(row);
        return path.depth > 0 || self.scene_.lights->lights()[path.light].kind != LightKind::portal_environment ||
               !self.scene_.lights->environment_radiance(path.light, point, -forward).is_black();
    }
    bool collides(std::uint32_t row, Real distance, const Ray& ray) {
        return is_in(row, ray.origin + ray.direction * distance, ray.direction);
    }
    bool arrives(std::size_t j) {
        const VertexBatch& v = self.vertices();
        if (!is_in(v.rows[j], v.points[j].position, v.rays[j].direction)) return false;
        // Joined with camera subpaths, which see another surface there (ShapeGeometry::faces_rays).
        if (self.options_.walk.densities && self.scene_.geometry->shapes()[v.hits[j].shape].faces_rays) return false;
        const bool worth = self.ahead(j).anything();
        if (!worth) self.walk_.counters().count(Pruned::light_paths);
        return worth;
    }
    bool worth_colliding(std::uint32_t row) {
        const std::int32_t label = self.record_.events().medium_label(self.path(row).medium);
        return self.record_.ahead(row, label, SurfacePoint::no_material).anything();
    }
    void passes_cutout(std::size_t j) {
        self.record_.pass_straight(self.vertices().rows[j], self.vertices().sources[j].label);
    }
    /// The strategy that joins at the light has the density of a light sample and not of an emission.
    void first_vertex(std::uint32_t row, const SurfacePoint& point, Real /*time*/, StrategySums& sums) {
        const LightSample& origin = self.origins_[row];
        const LightTable& lights = *self.scene_.lights;
        const auto sampled =
            static_cast<double>(lights.density(*self.options_.sampled, *self.scene_.geometry, point.position, origin));
        const bool area = lights.lights()[origin.light].is_area();
        sums.join = StrategySums::squared(sampled * (area ? sums.to_previous : 1) / sums.previous);
    }
};

void LightSubpaths::advance(display::DisplayServices& display) {
    Visitor visitor{{}, *this};
    walk_.advance(display, visitor);
}

}  // namespace raylex::transport
