// How a subpath of either direction is scattered at a surface.
//
// A light subpath carries power where a camera subpath carries importance. Its scattering is the camera's with the
// directions exchanged, f(towards camera, towards light): where shading and geometric normals differ, and where light
// crosses an interface, this is not symmetric. With cosines s to the shading and g to the geometric normal, power changes by
//     f(o, i) |s(i)| / |g(i)| x |g(o)| / density(o),   i towards the light, o towards the camera
// (Veach 1997, sections 5.2 and 5.3, equation 5.19), so that subpaths of both directions estimate one integral, word by
// word. Where closures draw walks (layered ones) their own weights are used, which are reciprocal, times
// |s(i) g(o)| / |g(i) s(o)|.
#pragma once

#include <cmath>

#include "transport/materials/closure.h"

namespace raylex::transport {

/// A direction that a subpath goes on in.
struct Scattering {
    Vec3 wi;
    Rgb weight;                ///< of the throughput
    float pdf = 0;             ///< per steradian; 0: the subpath ends. Of a specular one the lobe's probability
    float eta = 1;             ///< relative index crossed
    bool specular = false, transmitted = false;
    LobeList lobes;            ///< their parts of what was scattered, in any common scale
};

/// What is scattered from `point.wo`'s side towards `to`, ready to be joined with a subpath of the other direction: times
/// |cos| at the point, which leaves 1 / distance^2 of the geometry term, or for light subpaths that too.
struct JoinedScattering {
    Rgb value;
    float pdf = 0;             ///< with which the subpath would have gone there, per steradian
    float pdf_reverse = 0;     ///< with which one from there would have gone back
    LobeList lobes;
};

namespace scattering_detail {
inline float geometric_cosine(const SurfacePoint& point, const Vec3& direction) {
    return std::abs(dot(point.geometric_normal, direction));
}
}  // namespace scattering_detail

/// One sample of a closure for a subpath that came from point.wo. u_lobe and u in [0, 1). The radiance's 1 / eta^2 is in a
/// camera subpath's weight and not in a light subpath's.
inline Scattering sample_scattering(TransportMode mode, const Bsdf& bsdf, const SurfacePoint& point, float u_lobe,
                                    const Vec2& u) {
    const BsdfSample s = bsdf.sample(point.wo, u_lobe, u);
    Scattering result{s.wi, s.weight, s.pdf, s.eta, s.delta, s.transmitted, s.lobes};
    if (!(s.pdf > 0)) return result;
    if (s.pdf_is_proportional && !s.delta) result.pdf = bsdf.pdf(point.wo, s.wi);
    if (mode == TransportMode::radiance) return result;
    const float g_in = scattering_detail::geometric_cosine(point, point.wo),
                g_out = scattering_detail::geometric_cosine(point, s.wi);
    if (!(g_in > 0)) {
        result.pdf = 0;
        return result;
    }
    if (bsdf.kind() == Bsdf::Kind::lambert || s.delta || s.pdf_is_proportional) {
        const Vec3& n = bsdf.frame().n;
        const float s_in = std::abs(dot(n, point.wo)), s_out = std::abs(dot(n, s.wi));
        result.weight = s.weight * ((s_in / s_out) * (g_out / g_in) * (s.transmitted ? s.eta * s.eta : 1.0f));
    } else {
        const BsdfEvaluation f = bsdf.evaluate(s.wi, point.wo);
        result.weight = f.value * (g_out / (g_in * s.pdf));
        result.lobes = f.lobes;
    }
    return result;
}

/// With `densities`, of both directions.
inline JoinedScattering evaluate_scattering(TransportMode mode, const Bsdf& bsdf, const SurfacePoint& point,
                                            const Vec3& to, bool densities) {
    JoinedScattering result;
    if (mode == TransportMode::radiance) {
        const BsdfEvaluation f = bsdf.evaluate(point.wo, to);
        result = {f.value, f.pdf, 0, f.lobes};
        if (densities && !f.value.is_black()) result.pdf_reverse = bsdf.pdf(to, point.wo);
        return result;
    }
    const float g_in = scattering_detail::geometric_cosine(point, point.wo);
    if (!(g_in > 0)) return result;
    const BsdfEvaluation f = bsdf.evaluate(to, point.wo);
    result = {f.value * (scattering_detail::geometric_cosine(point, to) / g_in), 0, f.pdf, f.lobes};
    if (densities && !f.value.is_black()) result.pdf = bsdf.pdf(point.wo, to);
    return result;
}

}  // namespace raylex::transport
