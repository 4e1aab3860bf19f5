// How a subpath of either direction is scattered at a surface.
//
// A light subpath carries power where a camera subpath carries importance. Its scattering is the camera's with the
// directions exchanged, f(towards camera, towards light): where shading and geometric normals differ, and where light
// crosses an interface, this is not symmetric. With cosines s to the shading and g to the geometric normal, power
// changes by
//     f(o, i) |s(i)| / |g(i)| x |g(o)| / density(o),   i towards the light, o towards the camera
// (Veach 1997, sections 5.2 and 5.3, equation 5.19), so that subpaths of both directions estimate one integral, word by
// word. Where closures draw walks (layered ones) their own weights are used, which are reciprocal, times
// |s(i) g(o)| / |g(i) s(o)|.
#pragma once

#include <cmath>

#include "transport/paths/direction_sampler.h"
#include "transport/paths/subpath.h"

namespace raylex::transport {

/// Scattering from the side of `point.wo` towards a vertex of the other direction's subpath, times |cos| at the point.
/// Of the geometry term only 1 / distance^2 is left.
struct ConnectedScattering {
    BsdfEvaluation f;      ///< pdf: density per steradian with which the subpath goes on to the other vertex
    Real pdf_reverse = 0;  ///< density per steradian with which a subpath from the other vertex goes back
};

/// Updates a subpath that leaves a vertex, except its throughput.
template <TransportMode mode>
inline void leave_vertex(Subpath& path, const SurfacePoint& point, const BsdfSample& s) {
    ++path.depth;
    path.length += whole_event;
    ++path.segment;
    if (mode == TransportMode::radiance && s.transmitted) path.roulette_scale *= s.eta * s.eta;
    path.specular = s.delta;
    path.any_non_specular |= !s.delta;
    path.pdf = s.pdf;
    path.from = point.position;
    path.from_normal = point.shading_normal;
}

/// Turns the weight of a closure's sample for radiance into the weight for importance (Veach 1997, equation 5.19).
inline void weigh_importance(const Bsdf& bsdf, const SurfacePoint& point, BsdfSample& s) {
    const Real g_in = point.cosine(point.wo), g_out = point.cosine(s.wi);
    if (!(g_in > 0)) {
        s.pdf = 0;
        return;
    }
    const Vec3& n = bsdf.frame().n;
    const Real s_in = std::abs(dot(n, point.wo)), s_out = std::abs(dot(n, s.wi));
    s.weight *= (s_in / s_out) * (g_out / g_in) * (s.transmitted ? s.eta * s.eta : 1.0f);
}

/// One sample of a closure for a subpath that arrived from point.wo; u_lobe and u are in [0, 1). `pdf` of the result is
/// the density of the direction for every closure. The weight of a camera subpath contains the radiance's factor 1 /
/// eta^2; that of a light subpath does not.
template <TransportMode mode>
[[gnu::always_inline]] inline BsdfSample sample_scattering(const Bsdf& bsdf, const SurfacePoint& point, Real u_lobe,
                                                           const Vec2& u) {
    BsdfSample s = bsdf.sample(point.wo, u_lobe, u);
    if (!(s.pdf > 0)) return s;
    const Real drawn_with = s.pdf;
    if (s.pdf_is_proportional && !s.delta) s.pdf = bsdf.pdf(point.wo, s.wi);
    if constexpr (mode == TransportMode::importance) {
        const Real g_in = point.cosine(point.wo), g_out = point.cosine(s.wi);
        if (bsdf.holds<LambertClosure>() || s.delta || s.pdf_is_proportional || !(g_in > 0)) {
            weigh_importance(bsdf, point, s);
        } else {
            const BsdfEvaluation f = bsdf.evaluate(s.wi, point.wo);
            s.weight = f.value * (g_out / (g_in * drawn_with));
            s.lobes = f.lobes;
        }
    }
    return s;
}

/// Evaluates the scattering from point.wo towards a light sample, with the density for a subpath from the camera. If
/// `directions` is null, closures sample directions.
[[gnu::always_inline]] inline BsdfEvaluation evaluate_towards(const DirectionSampler* directions, const Bsdf& bsdf,
                                                              const SurfacePoint& point, const Vec3& to) {
    BsdfEvaluation f = bsdf.evaluate(point.wo, to);
    if (directions != nullptr && !f.value.is_black())
        f.pdf = directions->pdf(bsdf, point, TransportMode::radiance, to, f.pdf);
    return f;
}

/// Evaluates the scattering from point.wo to `to`, with the densities of both directions. Without `both`, only the
/// density for a subpath from the camera is set. If `directions` is null, closures sample directions.
template <TransportMode mode, bool both = true>
[[gnu::always_inline]] inline ConnectedScattering evaluate_scattering(const DirectionSampler* directions,
                                                                      const Bsdf& bsdf, const SurfacePoint& point,
                                                                      const Vec3& to) {
    if constexpr (mode == TransportMode::radiance) {
        ConnectedScattering result{evaluate_towards(directions, bsdf, point, to), 0};
        if (both && !result.f.value.is_black())
            result.pdf_reverse = direction_density<TransportMode::importance>(directions, bsdf, point, to, point.wo);
        return result;
    } else {
        const Real g_in = point.cosine(point.wo);
        if (!(g_in > 0)) return {};
        ConnectedScattering result{bsdf.evaluate(to, point.wo), 0};
        result.pdf_reverse = result.f.pdf;
        if (directions != nullptr)
            result.pdf_reverse = directions->pdf(bsdf, point, TransportMode::radiance, point.wo, result.pdf_reverse);
        result.f.value *= point.cosine(to) / g_in;
        result.f.pdf =
            both && !result.f.value.is_black() ? direction_density<mode>(directions, bsdf, point, point.wo, to) : 0.0f;
        return result;
    }
}

/// One sample of `directions` for a subpath that arrived from point.wo, at a closure that has a density. Directions
/// with a density leave `transmitted` and `eta` unset, which only roulette reads.
template <TransportMode mode>
[[gnu::noinline]] BsdfSample sample_direction(const DirectionSampler& directions, const Bsdf& bsdf,
                                              const SurfacePoint& point, Real u_lobe, const Vec2& u) {
    BsdfSample s = directions.sample(bsdf, point, mode, u_lobe, u);
    if (!(s.pdf > 0) || s.is_weighed) return s;
    if (s.delta || s.pdf_is_proportional) {
        if constexpr (mode == TransportMode::importance) weigh_importance(bsdf, point, s);
        return s;
    }
    const ConnectedScattering scattering = evaluate_scattering<mode, false>(nullptr, bsdf, point, s.wi);
    s.weight = scattering.f.value * (1 / s.pdf);
    s.lobes = scattering.f.lobes;
    s.transmitted = false;
    return s;
}

}  // namespace raylex::transport
