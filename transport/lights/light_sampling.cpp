// Sampling and densities by kind of light. Spheres seen from outside are sampled by the cone that they fill. Its 1 -
// cos is computed as s^2 / (1 + sqrt(1 - s^2)), which is exact for a sphere of 1e-8 of its distance (row 21 of the hard
// cases). Other area lights are sampled uniformly by area, which is stable for small and far ones.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "display/services/elementary.h"
#include "transport/lights/area_points.h"
#include "transport/lights/light_table.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

/// Converts a point of an area light, drawn with `area_density` (per world area), to a direction from `from`.
bool finish_area_sample(const Light& light, const Vec3& from, Real area_density, LightSample& s) {
    const Vec3 d = s.target - from;
    const Real d2 = length_squared(d);
    if (!(d2 > 0)) return false;
    s.wi = d / std::sqrt(d2);
    Real cosine = -dot(s.target_normal, s.wi);
    if (light.two_sided) cosine = std::abs(cosine);
    if (!(cosine > 0)) return false;
    s.pdf *= area_density * d2 / cosine;
    s.radiance = light.emission;
    return true;
}

bool sample_triangle(const Light& light, const Vec3& from, const Vec2& u, LightSample& s) {
    return finish_area_sample(light, from, sample_triangle_point(light, u, s), s);
}

bool sample_patch(const Light& light, const ShapeGeometry& shape, const Vec3& from, const Vec2& u, LightSample& s) {
    const Real density = sample_patch_point(light, shape, u, s);
    return density > 0 && finish_area_sample(light, from, density, s);
}

bool sample_quadric(const Light& light, const Quadric& quadric, const Vec3& from, const Vec2& u, LightSample& s) {
    return finish_area_sample(light, from, sample_quadric_point(quadric, u, s), s);
}

struct Cone {
    DVec3 to_center;
    double distance = 0, radius = 0, sin2 = 0;
    bool outside = false;
    double one_minus_cos = 0;
};

Cone cone_of(const Light& light, const Quadric& quadric, const Vec3& from) {
    Cone cone;
    cone.to_center = quadric.placement.to_world.point({0, 0, 0}) - DVec3(from);
    cone.distance = length(cone.to_center);
    cone.radius = std::sqrt(static_cast<double>(light.area) / (4 * std::numbers::pi));
    const double s = cone.radius / cone.distance;
    cone.sin2 = s * s;
    // Closer than this, the cone is a half space, and rounded points may fall on either side of the surface.
    cone.outside = cone.distance > cone.radius * (1 + 1e-6);
    if (cone.outside) cone.one_minus_cos = cone.sin2 / (1 + std::sqrt(1 - cone.sin2));
    return cone;
}

/// `cut_out`: the shape has alpha, so s.uv is needed.
bool sample_sphere(const Light& light, const Quadric& quadric, bool cut_out, const Vec3& from, const Vec2& u,
                   LightSample& s) {
    const Cone cone = cone_of(light, quadric, from);
    if (!cone.outside) return sample_quadric(light, quadric, from, u, s);
    if (quadric.reversed && !light.two_sided) return false;
    const double h = u.x * cone.one_minus_cos;  // 1 - cos(theta)
    const double sin2 = h * (2 - h), cos_theta = 1 - h;
    // The near point is where the ray meets the sphere: alpha is its angle at the centre (pbrt-v4, section 6.2.4).
    const double ratio = std::min(sin2 / cone.sin2, 1.0);
    const double cos_alpha = sin2 / std::sqrt(cone.sin2) + cos_theta * std::sqrt(1 - ratio);
    const double sin_alpha = std::sqrt(std::max(0.0, 1 - cos_alpha * cos_alpha));
    const Vec3 axis = (cone.to_center * (1 / cone.distance)).to_real();
    const Frame frame = Frame::from_normal(axis);
    const auto [sn, c] = elementary::sin_cos(2 * pi * u.y);
    const Real sin_theta = static_cast<Real>(std::sqrt(sin2));
    s.wi = normalize(frame.s * (sin_theta * c) + frame.t * (sin_theta * sn) + axis * static_cast<Real>(cos_theta));
    const Vec3 outward = normalize(frame.s * (static_cast<Real>(sin_alpha) * c) +
                                   frame.t * (static_cast<Real>(sin_alpha) * sn) - axis * static_cast<Real>(cos_alpha));
    s.target = (DVec3(from) + cone.to_center + DVec3(outward) * cone.radius).to_real();
    s.target_normal = outward;
    s.target_offset = offset_of_rounded(outward, s.target, quadric.extent());
    if (cut_out) {
        double a, b;
        quadric.parameters(quadric.placement.to_object.point(DVec3(s.target)), a, b);
        s.uv = {static_cast<Real>(a), static_cast<Real>(b)};
    }
    s.pdf *= static_cast<Real>(1 / (2 * std::numbers::pi * cone.one_minus_cos));
    s.radiance = light.emission;
    return true;
}

EnvironmentImage::By drawn_by(const LightChooser& chooser) {
    return chooser.compensates() ? EnvironmentImage::By::excess : EnvironmentImage::By::radiance;
}

}  // namespace

bool LightTable::sample_at_point(const Light& light, const Vec3& from, LightSample& s) const {
    const Vec3 d = light.position - from;
    const Real d2 = length_squared(d);
    if (!(d2 > 0)) return false;
    s.wi = d / std::sqrt(d2);
    s.target = light.position;
    s.delta = true;
    Real falloff = 1;
    if (light.kind == LightKind::spot) {
        falloff = light.image >= 0 ? stretched_spot(light).falloff(-s.wi)
                                   : spot_falloff(light.direction, light.versine_full, light.versine_zero, -s.wi);
        if (!(falloff > 0)) return false;
    }
    s.radiance = light.emission * (falloff / d2);
    return true;
}

bool LightTable::sample_infinite(const LightChooser& chooser, const Light& light, const Vec3& from, const Vec2& u,
                                 LightSample& s) const {
    s.infinite = true;
    if (light.kind == LightKind::distant) {
        s.wi = light.direction;
        s.radiance = light.emission;
        s.delta = true;
        return true;
    }
    if (light.kind == LightKind::uniform_environment) {
        s.wi = sample_uniform_sphere(u);
        s.radiance = light.emission;
        s.pdf *= uniform_sphere_pdf();
        return true;
    }
    Real pdf = 0;
    Rgb radiance;
    const bool any = light.kind == LightKind::portal_environment
                         ? portal_of(light).sample(from, u, s.wi, radiance, pdf)
                         : environment_of(light).sample(u, s.wi, radiance, pdf, drawn_by(chooser));
    if (!any) return false;
    s.radiance = radiance * light.emission;
    s.pdf *= pdf;
    return true;
}

/// Samples lights at a point and area lights that have an image.
bool LightTable::sample_image_light(const Light& light, const EmbreeScene& geometry, const Vec3& from, const Vec2& u,
                                    LightSample& s) const {
    if (light.is_at_point()) {
        if (!sample_at_point(light, from, s)) return false;
        if (light.kind == LightKind::spot) return true;
        s.radiance *= intensity_of(light).intensity(-s.wi);
        return !s.radiance.is_black();
    }
    const Real density = sample_area_point(geometry, light, u, s);
    if (!(density > 0) || !finish_area_sample(light, from, density, s)) return false;
    s.radiance *= shown_at(light, geometry, s.uv);
    return true;
}

Rgb LightTable::shown_at(const Light& light, const EmbreeScene& geometry, const Vec2& at) const {
    const Vec2 place = texture_coordinates(geometry.shapes()[light.shape], light.primitive, at);
    return shown(light).radiance(place.x, place.y);
}

Real LightTable::image_density(const Light& light, const ShapeGeometry& shape, const Vec2& at) const {
    return images_.points[static_cast<std::size_t>(light.image)].points.density_at(numbers_of_point(light, shape, at));
}

bool LightTable::sample(const LightChooser& chooser, const EmbreeScene& geometry, const LightReceiver& receiver,
                        Real u_choice, Vec2 u, LightSample& s) const {
    if (chooser.empty()) return false;
    s = LightSample();
    const LightTree::Chosen chosen = chooser.choose(receiver, u_choice, u);
    if (chosen.light == LightTree::none || !(chosen.probability > 0)) return false;
    const Vec3& from = receiver.position;
    s.light = chosen.light;
    s.pdf = chosen.probability;
    const Light& light = lights_[s.light];
    s.delta = light.hidden;
    if (light.image >= 0 && !light.is_environment()) return sample_image_light(light, geometry, from, u, s);
    switch (light.kind) {
        case LightKind::triangle:
            return sample_triangle(light, from, u, s);
        case LightKind::patch:
            return sample_patch(light, geometry.shapes()[light.shape], from, u, s);
        case LightKind::quadric:
            return sample_quadric(light, geometry.shapes()[light.shape].quadric, from, u, s);
        case LightKind::sphere:
            return sample_sphere(light, geometry.shapes()[light.shape].quadric,
                                 geometry.shapes()[light.shape].alpha >= 0, from, u, s);
        case LightKind::point:
        case LightKind::spot:
            return sample_at_point(light, from, s);
        default:
            return sample_infinite(chooser, light, from, u, s);
    }
}

Real LightTable::density(const LightChooser& chooser, const EmbreeScene& geometry, std::uint32_t index,
                         const LightReceiver& receiver, const SurfacePoint& at, const Hit& hit) const {
    const Light& light = lights_[index];
    const Vec3& from = receiver.position;
    const Real chosen = chooser.probability(receiver, index);
    if (!(chosen > 0)) return 0;
    const ShapeGeometry& shape = geometry.shapes()[light.shape];
    if (light.kind == LightKind::sphere) {
        const Cone cone = cone_of(light, shape.quadric, from);
        // The cone's samples lie on the near side; the far side is visible only through holes in it.
        const DVec3 out = DVec3(at.position) - shape.quadric.placement.to_world.point({0, 0, 0});
        if (cone.outside && shape.alpha >= 0 && dot(out, DVec3(from) - DVec3(at.position)) < 0) return 0;
        if (cone.outside) return chosen * static_cast<Real>(1 / (2 * std::numbers::pi * cone.one_minus_cos));
    }
    double area_density = density_of_point(light, shape, {hit.u, hit.v});
    if (light.image >= 0) area_density *= static_cast<double>(image_density(light, shape, {hit.u, hit.v}));
    const Vec3 d = at.position - from;
    const Real d2 = length_squared(d);
    const Real cosine = std::abs(dot(at.geometric_normal, d)) / std::sqrt(d2);
    return cosine > 0 ? chosen * static_cast<Real>(area_density) * d2 / cosine : infinity;
}

Real LightTable::density(const LightChooser& chooser, const EmbreeScene& geometry, const LightReceiver& from,
                         const LightSample& at) const {
    const Light& light = lights_[at.light];
    if (light.is_area()) {
        SurfacePoint point;
        point.position = at.target;
        point.geometric_normal = at.target_normal;
        Hit hit;
        hit.u = at.uv.x;
        hit.v = at.uv.y;
        return density(chooser, geometry, at.light, from, point, hit);
    }
    if (light.is_environment()) return environment_density(chooser, at.light, from.position, at.wi);
    return chooser.probability(from, at.light);
}

Real LightTable::environment_density(const LightChooser& chooser, std::uint32_t index, const Vec3& from,
                                     const Vec3& direction) const {
    const Light& light = lights_[index];
    const Real chosen = chooser.probability(Vec3(), index);  // from every receiver
    if (!(chosen > 0)) return 0;
    if (light.kind == LightKind::uniform_environment) return chosen * uniform_sphere_pdf();
    return chosen * (light.kind == LightKind::portal_environment
                         ? portal_of(light).pdf(from, direction)
                         : environment_of(light).pdf(direction, drawn_by(chooser)));
}

Rgb LightTable::environment_radiance(std::uint32_t index, const Vec3& from, const Vec3& direction) const {
    const Light& light = lights_[index];
    if (light.kind == LightKind::uniform_environment) return light.emission;
    return light.emission * (light.kind == LightKind::portal_environment ? portal_of(light).radiance(from, direction)
                                                                         : environment_of(light).radiance(direction));
}

}  // namespace raylex::transport
