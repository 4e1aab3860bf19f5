#include "transport/render/pilots/last_vertex.h"

#include <algorithm>
#include <array>
#include <vector>

#include "transport/cameras/camera.h"
#include "transport/math/sampling.h"
#include "transport/paths/subpaths/camera_subpaths.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {
namespace {

constexpr std::uint32_t pilot_grid = 16, pilot_samples = 32;

/// Light that one technique finds from a vertex.
struct Found {
    double value = 0;         ///< without the MIS weight
    Real own = 0, other = 0;  ///< densities, of the technique and of the other one
};

struct PilotPath {
    Found light, ray;
};

/// Integrals over the directions from a vertex, in the mean over those seen in a pixel.
struct Moments {
    double second = 0, by_light = 0, by_ray = 0;

    /// Samples of both techniques estimate the integrals, weighted as if both were always taken: where one technique
    /// finds little and is noisy, the other gives the estimate.
    void add(const Found& found, bool is_light, const TechniqueShares& shares) {
        if (!(found.value > 0)) return;
        const double f = found.value * double{found.own};
        const double chance = double{power_heuristic(found.own, found.other)} / double{found.own};
        const Real light = shares.light * (is_light ? found.own : found.other),
                   ray = shares.ray * (is_light ? found.other : found.own);
        const double w = double{power_heuristic(light, ray)};
        if (light > 0) second += chance * f * f * w * w / double{light};
        if (ray > 0) second += chance * f * f * (1 - w) * (1 - w) / double{ray};
        by_light += chance * f * w;
        by_ray += chance * f * (1 - w);
    }
};

/// On the way from one surface to the next.
struct Journey {
    Ray ray;
    std::int32_t medium = -1;
    Rgb through = Rgb(1);  ///< that media let pass
    Hit hit;
    SurfacePoint point;
    SurfaceSource source;
};

class Pilot {
  public:
    Pilot(const IntegratorContext& context, const LiveLights& lights)
        : context_(context),
          scene_(context.scene),
          lights_(lights),
          record_(*context.events, 1),
          table_(context.services.channels, 1, 0),
          lpe_(context.services.on(table_)) {}

    /// Returns false if the vertices that the camera sees first are not last ones.
    bool run() {
        for (std::uint32_t y = 0; y < pilot_grid; ++y)
            for (std::uint32_t x = 0; x < pilot_grid; ++x)
                for (std::uint32_t s = 0; s < pilot_samples; ++s)
                    if (!trace(x, y, s)) return false;
        return true;
    }

    /// Whether some channel takes light that a medium scatters towards the camera. The pilot has no such vertices.
    [[nodiscard]] bool media_scatter() {
        record_.begin(lpe_, 1);
        for (std::int32_t medium = 0; medium < static_cast<std::int32_t>(scene_.media->size()); ++medium)
            if ((*scene_.media)[medium].scatters && record_.is_live_in_medium(0, medium)) return true;
        return false;
    }
    [[nodiscard]] std::uint64_t rays() const { return rays_ + counters_.shadow_rays; }
    [[nodiscard]] double cost_times_variance(const TechniqueShares& shares) const {
        std::vector<Moments> pixels;
        double overall = 0;
        for (std::size_t first = 0; first < paths_.size(); first += pilot_samples) {
            Moments& pixel = pixels.emplace_back();
            for (std::size_t i = first; i < first + pilot_samples; ++i) {
                pixel.add(paths_[i].light, true, shares);
                pixel.add(paths_[i].ray, false, shares);
            }
            for (double* each : {&pixel.second, &pixel.by_light, &pixel.by_ray}) *each /= pilot_samples;
            overall += (pixel.by_light + pixel.by_ray) / (double(pilot_grid) * pilot_grid);
        }
        double sum = 0;
        for (const Moments& pixel : pixels) {
            const double mean = pixel.by_light + pixel.by_ray;
            const double variance =
                std::max(0.0, pixel.second - pixel.by_light * pixel.by_light - pixel.by_ray * pixel.by_ray);
            // Differences below this are rounding: a technique without noise is not to be preferred for its last bits.
            if (variance > 1e-9 * mean * mean) sum += variance / (mean * mean + 0.01 * overall * overall);
        }
        // In camera rays, whose hits are shaded too.
        return (sum + 1e-6) * (1.3 + 0.7 * double{shares.light} + double{shares.ray});
    }

  private:
    bool trace(std::uint32_t x, std::uint32_t y, std::uint32_t s);
    template <class Pass>
    bool travel(Journey& journey, FlightNumbers numbers, Pass pass);
    [[nodiscard]] std::int32_t medium_towards(const Journey& at, const Vec3& direction) const {
        const ShapeGeometry& shape = scene_.geometry->shapes()[at.hit.shape];
        return shape.border ? shape.medium_towards(at.point.geometric_normal, direction, at.medium) : at.medium;
    }
    [[nodiscard]] Found sample_light(const LightChooser& chooser, const PixelSampler& numbers);
    [[nodiscard]] Found sample_ray(const LightChooser& chooser, const PixelSampler& numbers, std::uint64_t terminals);

    const IntegratorContext& context_;
    const SceneView scene_;
    const LiveLights& lights_;
    Record record_;
    display::SampleTable table_;
    display::LpeServices lpe_;
    std::vector<PilotPath> paths_;
    Journey first_;  // from the camera
    Bsdf bsdf_;
    IntegratorCounters counters_;
    std::uint64_t rays_ = 0;
};

/// Follows the ray to the surface where it ends. As for paths, a cutout is passed by chance; then calls `pass`. Returns
/// false if the ray ends at no surface.
template <class Pass>
bool Pilot::travel(Journey& journey, FlightNumbers numbers, Pass pass) {
    Ray& ray = journey.ray;
    for (;;) {
        ++rays_;
        scene_.geometry->intersect({&ray, 1}, {&journey.hit, 1});
        const Hit& hit = journey.hit;
        if (journey.medium >= 0) {
            const Medium& crossed = (*scene_.media)[journey.medium];
            const Real distance = hit.valid() ? hit.t : infinity;
            journey.through *= crossed.grid == nullptr
                                   ? transmittance(crossed, distance)
                                   : crossed.grid->transmittance({ray.origin, ray.direction, distance}, numbers.row());
        }
        if (!hit.valid()) return false;
        scene_.geometry->surfaces({&ray, 1}, {&hit, 1}, {&journey.point, 1}, {&journey.source, 1});
        const ShapeGeometry& shape = scene_.geometry->shapes()[hit.shape];
        if (shape.alpha < 0 || numbers.next() < scene_.opacity(shape, journey.point)) return true;
        pass();
        journey.medium = medium_towards(journey, ray.direction);
        ray.origin = straight_ray_origin(ray, hit.t, journey.point.position, journey.point.geometric_normal,
                                         journey.source.offset.here);
    }
}

bool Pilot::trace(std::uint32_t x, std::uint32_t y, std::uint32_t s) {
    const PixelSampler numbers(SamplerKind::sobol, context_.services.seed, static_cast<std::int32_t>(x),
                               static_cast<std::int32_t>(y), s);
    const Vec2 at = numbers.get_2d(filter_dimension);
    record_.begin(lpe_, 1);
    first_ = {};
    first_.medium = scene_.media->camera();
    first_.ray = context_.view.camera->generate(
        {(static_cast<Real>(x) + at.x) * static_cast<Real>(context_.view.width) / pilot_grid,
         (static_cast<Real>(y) + at.y) * static_cast<Real>(context_.view.height) / pilot_grid,
         numbers.get_2d(lens_dimension), sample_time(scene_, numbers)});
    PilotPath& path = paths_.emplace_back();
    if (!travel(first_, FlightNumbers(numbers.key(5), 1), [&] { record_.pass_through(0, first_.source.label); }))
        return true;
    SurfacePoint& point = first_.point;
    const display::Liveness::LiveSet live = record_.live_set(0, first_.source.label, point.material);
    if (live.scatters) return false;
    const LightChooser& chooser = lights_[lights_.of(live)];
    if (!live.anything || chooser.empty()) return true;
    point.random_key = numbers.key(5);
    scene_.materials->shade(*scene_.textures, {&point, 1}, {&bsdf_, 1});
    if (!bsdf_.has_density()) return true;
    path.light = sample_light(chooser, numbers);
    path.ray = sample_ray(chooser, numbers, live.terminals);
    return true;
}

Found Pilot::sample_light(const LightChooser& chooser, const PixelSampler& numbers) {
    const SurfacePoint& point = first_.point;
    LightSample sample;
    if (!scene_.lights->sample(chooser, *scene_.geometry, {point.position, point.shading_normal}, numbers.get_1d(8),
                               numbers.get_2d(9), sample))
        return {};
    if (scene_.tests_alpha()) sample.radiance *= emitter_opacity(scene_, sample, point.position);
    const BsdfEvaluation f = evaluate_towards(context_.directions, bsdf_, point, sample.wi);
    if (f.value.is_black()) return {};
    Ray ray = shadow_ray(point.position, point.geometric_normal, first_.source.offset.here, sample);
    ray.time = first_.ray.time;
    ++rays_;
    std::uint8_t blocked = 0;
    scene_.geometry->occluded({&ray, 1}, {&blocked, 1});
    if (blocked) return {};
    Rgb through = first_.through;
    Real visible = 1;
    if (scene_.tests_alpha() || scene_.media->any()) {
        display::Tracker tracker = record_.tracker(0);
        visible = pass_through_transmittance(
            {.scene = scene_, .record = record_, .counters = counters_, .numbers = FlightNumbers(numbers.key(5), 2)},
            ray, visible, medium_towards(first_, sample.wi), tracker, through);
    }
    return {double{(f.value * sample.radiance * through).average() * visible} / double{sample.pdf}, sample.pdf,
            sample.delta ? 0 : f.pdf};
}

Found Pilot::sample_ray(const LightChooser& chooser, const PixelSampler& numbers, std::uint64_t terminals) {
    const SurfacePoint& point = first_.point;
    const Real u_lobe = numbers.get_1d(11);
    const Vec2 u = numbers.get_2d(10);
    constexpr TransportMode mode = TransportMode::radiance;
    const BsdfSample s = context_.directions == nullptr
                             ? sample_scattering<mode>(bsdf_, point, u_lobe, u)
                             : sample_direction<mode>(*context_.directions, bsdf_, point, u_lobe, u);
    if (!(s.pdf > 0) || s.weight.is_black() || s.delta) return {};
    Journey onward;
    onward.ray.origin = offset_ray_origin(point.position, point.geometric_normal, first_.source.offset.here, s.wi);
    onward.ray.direction = s.wi;
    onward.ray.time = first_.ray.time;
    onward.medium = medium_towards(first_, s.wi);
    onward.through = first_.through;
    const bool arrives = travel(onward, FlightNumbers(numbers.key(5), 3), [] {});
    const Rgb weight = s.weight * onward.through;
    const auto counts = [&](std::uint32_t light) {
        return (terminals & context_.events->liveness().bit_of(context_.events->terminal(light))) != 0;
    };
    const LightTable& lights = *scene_.lights;
    if (!arrives) {
        Found found;
        for (const std::uint32_t light : lights.environments()) {
            if (!counts(light)) continue;
            found.value += double{(weight * lights.environment_radiance(light, point.position, s.wi)).average()};
            found.own = s.pdf;
            found.other += lights.environment_density(chooser, light, point.position, s.wi);
        }
        return found;
    }
    const ShapeGeometry& shape = scene_.geometry->shapes()[onward.hit.shape];
    const std::uint32_t light = shape.first_light + onward.hit.primitive;
    if (shape.first_light == Hit::none || !counts(light)) return {};
    const SurfacePoint& there = onward.point;
    const Rgb emitted = lights.emitted(light, there, there.wo);
    return {
        double{(weight * emitted).average()}, s.pdf,
        lights.density(chooser, *scene_.geometry, light, {point.position, point.shading_normal}, there, onward.hit)};
}

/// Whether light samples can be left out: rays can find all lights that some channel takes. Checks the lights and not
/// the pilot's samples, because few pixels may see a spot light.
bool rays_find_all(const IntegratorContext& context) {
    const display::Liveness& liveness = context.events->liveness();
    const std::uint64_t live = liveness.live_terminals();
    const std::span<const Light> lights = context.scene.lights->lights();
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        if (lights[light].is_delta() && lights[light].power > 0 &&
            (live & liveness.bit_of(context.events->terminal(light))) != 0)
            return false;
    return true;
}

}  // namespace

TechniqueShares choose_techniques(const IntegratorContext& context, const LiveLights& lights, std::uint64_t& rays) {
    if (context.beauty || !context.events->prunes() || context.events->wants_user() ||
        context.scene.media->any_emits() || context.scene.media->any_bodies())
        return {};
    Pilot pilot(context, lights);
    if (pilot.media_scatter()) return {};
    const bool applies = pilot.run();
    rays += pilot.rays();
    if (!applies) return {};
    TechniqueShares best;
    double least = 0.95 * pilot.cost_times_variance(best);
    const auto consider = [&](const TechniqueShares& shares) {
        const double product = pilot.cost_times_variance(shares);
        if (!(product < least)) return;
        least = product;
        best = shares;
    };
    for (const Real ray : {Real(0.5), Real(0.25), Real(0.125), Real(0.0625)}) consider({1, ray});
    for (const Real light : {Real(0.5), Real(0.25), Real(0.125)}) consider({light, 1});
    if (rays_find_all(context)) consider({0, 1});
    return best;
}

}  // namespace raylex::transport
