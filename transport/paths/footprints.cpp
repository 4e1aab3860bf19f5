#include "transport/paths/footprints.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

constexpr Real least_share = 0.125f, least_cosine = 0.01f;

/// The change of texture coordinates along `side`, which lies in the tangents' plane.
Vec2 coordinates_along(const SurfaceTangents& t, const Vec3& side) {
    const Real uu = dot(t.dpdu, t.dpdu), uv = dot(t.dpdu, t.dpdv), vv = dot(t.dpdv, t.dpdv);
    const Real determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) return {0, 0};
    const Real su = dot(side, t.dpdu), sv = dot(side, t.dpdv);
    return {(su * vv - sv * uv) / determinant, (sv * uu - su * uv) / determinant};
}

/// How much the normal turns for a unit of length, over both tangents; positive where the surface bulges towards wo.
Real bulge(const SurfaceTangents& t, const SurfacePoint& point) {
    const Real uu = length_squared(t.dpdu), vv = length_squared(t.dpdv);
    if (!(uu > 0 && vv > 0)) return 0;
    const Real mean = Real(0.5) * (dot(t.dndu, t.dpdu) / uu + dot(t.dndv, t.dpdv) / vv);
    return dot(point.shading_normal, point.wo) < 0 ? -mean : mean;
}

}  // namespace

Real pixel_share(std::uint64_t sample) {
    return std::max(least_share, 1 / std::sqrt(static_cast<Real>(std::min<std::uint64_t>(sample, 64)) + 1));
}

RayCone cone_of_sample(const RayCone& of_pixel, std::uint64_t sample) {
    const Real share = pixel_share(sample);
    return {of_pixel.width * share, of_pixel.spread * share};
}

SurfaceFootprint footprint_of(const SurfaceTangents& tangents, const SurfacePoint& point, Real width) {
    const Vec3& n = point.geometric_normal;
    const Real cosine = dot(n, point.wo), size = std::abs(width);
    const Vec3 slope = point.wo - n * cosine;  // in the surface, towards the eye
    const Real l2 = length_squared(slope);
    const Vec3 along = l2 > Real(1e-12) ? slope / std::sqrt(l2) : Frame::from_normal(n).s;
    SurfaceFootprint footprint;
    footprint.first = along * (size / std::max(std::abs(cosine), least_cosine));
    footprint.second = cross(n, along) * size;
    footprint.first_uv = coordinates_along(tangents, footprint.first);
    footprint.second_uv = coordinates_along(tangents, footprint.second);
    return footprint;
}

RayCone scattered_cone(const EmbreeScene& geometry, const Hit& hit, const SurfacePoint& point,
                       const BsdfSample& sample) {
    RayCone cone = hit.cone;
    if (!sample.delta) {
        // A cone of full angle a holds pi a^2 / 4 steradians; the sample stands for 1 / pdf of them. The density is the
        // closure's: with that of a sampler of directions, filtered textures would have another mean.
        const Real closure_pdf = sample.drawn_over_pdf == 1 ? sample.pdf / sample.favoured : sample.pdf;
        const Real angle = least_share * 2 / std::sqrt(pi * closure_pdf);
        if (angle > std::abs(cone.spread)) cone.spread = angle;
        return cone;
    }
    if (point.material == SurfacePoint::no_material) return cone;
    const Real cosine = std::max(std::abs(dot(point.shading_normal, point.wo)), least_cosine);
    const Real turn = bulge(geometry.tangents(hit, point), point) * cone.width / cosine;  // of the normal, across
    if (sample.transmitted) {
        const Real ratio = sample.eta > 0 ? 1 / sample.eta : 1;
        cone.spread = cone.spread * ratio - (1 - ratio) * turn;
    } else {
        cone.spread += 2 * turn;
    }
    if (!std::isfinite(cone.spread)) cone.spread = hit.cone.spread;
    return cone;
}

}  // namespace raylex::transport
