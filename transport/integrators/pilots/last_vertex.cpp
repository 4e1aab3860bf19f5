#include "transport/integrators/pilots/last_vertex.h"

#include <algorithm>
#include <array>
#include <vector>

#include "transport/cameras/camera.h"
#include "transport/math/sampling.h"
#include "transport/paths/subpaths/connect.h"

namespace raylex::transport {
namespace {

constexpr std::uint32_t pilot_grid = 16, pilot_samples = 32;

/// What one technique finds from a vertex.
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

    /// Both techniques' samples estimate them, weighed as if each were always taken: what one of them hardly finds, and
    /// would be noisy in, the other shows.
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

class Pilot {
  public:
    Pilot(const IntegratorContext& context, const LiveLights& lights)
        : context_(context),
          scene_(context.scene),
          lights_(lights),
          record_(*context.events, 1),
          table_(context.channels, 1, 0),
          lpe_(*context.lpe, table_, context.seed, context.attribution) {}

    /// False where the shares of last vertices do not apply to what the camera sees first.
    bool run() {
        for (std::uint32_t y = 0; y < pilot_grid; ++y)
            for (std::uint32_t x = 0; x < pilot_grid; ++x)
                for (std::uint32_t s = 0; s < pilot_samples; ++s)
                    if (!trace(x, y, s)) return false;
        return true;
    }

    [[nodiscard]] std::uint64_t rays() const { return rays_; }
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
    [[nodiscard]] Found sample_light(const LightChooser& chooser, const PixelSampler& numbers);
    [[nodiscard]] Found sample_ray(const LightChooser& chooser, const PixelSampler& numbers, std::uint64_t terminals);

    const IntegratorContext& context_;
    const SceneView scene_;
    const LiveLights& lights_;
    Record record_;
    display::SampleTable table_;
    display::LpeServices lpe_;
    std::vector<PilotPath> paths_;
    SurfacePoint point_;
    SurfaceSource source_;
    Bsdf bsdf_;
    Real time_ = 0;
    std::uint64_t rays_ = 0;
};

bool Pilot::trace(std::uint32_t x, std::uint32_t y, std::uint32_t s) {
    const PixelSampler numbers(SamplerKind::sobol, context_.seed, static_cast<std::int32_t>(x),
                               static_cast<std::int32_t>(y), s);
    const Vec2 at = numbers.get_2d(filter_dimension);
    const Ray ray =
        context_.camera->generate({(static_cast<Real>(x) + at.x) * static_cast<Real>(context_.width) / pilot_grid,
                                   (static_cast<Real>(y) + at.y) * static_cast<Real>(context_.height) / pilot_grid,
                                   numbers.get_2d(lens_dimension), sample_time(scene_, numbers)});
    time_ = ray.time;
    PilotPath& path = paths_.emplace_back();
    ++rays_;
    Hit hit;
    scene_.geometry->intersect({&ray, 1}, {&hit, 1});
    if (!hit.valid()) return true;
    scene_.geometry->surfaces({&ray, 1}, {&hit, 1}, {&point_, 1}, {&source_, 1});
    record_.begin(lpe_, 1);
    const display::Foresight::Ahead ahead = record_.ahead(0, source_.label, point_.material);
    if (ahead.scatters) return false;
    const LightChooser& chooser = lights_[lights_.of(ahead)];
    if (!ahead.anything || chooser.empty()) return true;
    point_.random_key = numbers.key(5);
    scene_.materials->shade(*scene_.textures, {&point_, 1}, {&bsdf_, 1});
    if (!bsdf_.has_density()) return true;
    path.light = sample_light(chooser, numbers);
    path.ray = sample_ray(chooser, numbers, ahead.terminals);
    return true;
}

Found Pilot::sample_light(const LightChooser& chooser, const PixelSampler& numbers) {
    LightSample sample;
    if (!scene_.lights->sample(chooser, *scene_.geometry, {point_.position, point_.shading_normal}, numbers.get_1d(8),
                               numbers.get_2d(9), sample))
        return {};
    const BsdfEvaluation f = bsdf_.evaluate(point_.wo, sample.wi);
    if (f.value.is_black()) return {};
    Ray ray = shadow_ray(point_.position, point_.geometric_normal, source_.offset.here, sample);
    ray.time = time_;
    ++rays_;
    std::uint8_t blocked = 0;
    scene_.geometry->occluded({&ray, 1}, {&blocked, 1});
    if (blocked) return {};
    return {double{(f.value * sample.radiance).average()} / double{sample.pdf}, sample.pdf, sample.delta ? 0 : f.pdf};
}

Found Pilot::sample_ray(const LightChooser& chooser, const PixelSampler& numbers, std::uint64_t terminals) {
    const BsdfSample s =
        sample_scattering<TransportMode::radiance>(bsdf_, point_, numbers.get_1d(11), numbers.get_2d(10));
    if (!(s.pdf > 0) || s.weight.is_black() || s.delta) return {};
    Ray ray;
    ray.origin = offset_ray_origin(point_.position, point_.geometric_normal, source_.offset.here, s.wi);
    ray.direction = s.wi;
    ray.time = time_;
    ++rays_;
    Hit hit;
    scene_.geometry->intersect({&ray, 1}, {&hit, 1});
    const auto counts = [&](std::uint32_t light) {
        return (terminals & context_.events->foresight().bit_of(context_.events->terminal(light))) != 0;
    };
    const LightTable& lights = *scene_.lights;
    if (!hit.valid()) {
        Found found;
        for (const std::uint32_t light : lights.environments()) {
            if (!counts(light)) continue;
            found.value += double{(s.weight * lights.environment_radiance(light, point_.position, s.wi)).average()};
            found.own = s.pdf;
            found.other += lights.environment_density(chooser, light, point_.position, s.wi);
        }
        return found;
    }
    const ShapeGeometry& shape = scene_.geometry->shapes()[hit.shape];
    if (shape.first_light == Hit::none || !counts(shape.first_light + hit.primitive)) return {};
    SurfacePoint there;
    SurfaceSource source;
    scene_.geometry->surfaces({&ray, 1}, {&hit, 1}, {&there, 1}, {&source, 1});
    const std::uint32_t light = shape.first_light + hit.primitive;
    const Rgb emitted = lights.emitted(light, there, there.wo);
    return {double{(s.weight * emitted).average()}, s.pdf,
            lights.density(chooser, *scene_.geometry, light, {point_.position, point_.shading_normal}, there, hit)};
}

/// Whether light samples can be left out: a ray can find all of the lights that some channel takes. Asked of the lights
/// and not of what a pilot met: a spot may be seen by few pixels.
bool rays_find_all(const IntegratorContext& context) {
    const display::Foresight& foresight = context.events->foresight();
    const std::uint64_t live = foresight.terminals_ever();
    const std::span<const Light> lights = context.scene.lights->lights();
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        if (lights[light].is_delta() && lights[light].power > 0 &&
            (live & foresight.bit_of(context.events->terminal(light))) != 0)
            return false;
    return true;
}

}  // namespace

TechniqueShares choose_techniques(const IntegratorContext& context, const LiveLights& lights, std::uint64_t& rays) {
    if (context.beauty || !context.events->prunes() || context.events->wants_user() || context.scene.media->any() ||
        context.scene.geometry->has_alpha())
        return {};
    Pilot pilot(context, lights);
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
