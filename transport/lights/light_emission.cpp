// Emission from lights, for paths that begin there.
#include <cmath>

#include "transport/lights/area_points.h"
#include "transport/lights/light_table.h"

namespace raylex::transport {
namespace {

/// The radius of the disk that covers the scene: slightly more than the sphere about its bounds, so that rounding cuts
/// nothing off.
Real covering_radius(const EmbreeScene& geometry) {
    return std::max(geometry.lit_bounds().radius(), Real(1e-30)) * (1 + Real(1e-5));
}

bool emit_from_area(const Light& light, Real area_density, Vec2 u, EmissionSample& s) {
    if (!(area_density > 0)) return false;
    Vec3 n = s.from.target_normal;
    if (light.two_sided) {
        const bool back = u.x >= 0.5f;
        u.x = back ? remap_above(u.x, 0.5f) : remap_below(u.x, 0.5f);
        if (back) n = -n;
        area_density *= 0.5f;
    }
    const Vec3 local = sample_cosine_hemisphere(u);
    if (!(local.z > 0)) return false;
    s.direction = normalize(Frame::from_normal(n).to_world(local));
    s.origin = offset_ray_origin(s.from.target, s.from.target_normal, s.from.target_offset.here, s.direction);
    s.power = light.emission * (pi / (s.from.pdf * area_density));
    return true;
}

}  // namespace

bool LightTable::emit_from_point(const Light& light, const Vec2& u, EmissionSample& s) const {
    s.origin = light.position;
    if (light.kind == LightKind::point) {
        s.direction = sample_uniform_sphere(u);
        s.power = light.emission * (4 * pi / s.from.pdf);
        return true;
    }
    if (light.kind != LightKind::spot) {
        Rgb intensity;
        Real pdf = 0;
        if (!intensity_of(light).sample(u, s.direction, intensity, pdf)) return false;
        s.power = light.emission * intensity * (1 / (pdf * s.from.pdf));
        return true;
    }
    if (light.image >= 0) {
        Real falloff = 0, pdf = 0;
        if (!stretched_spot(light).sample(u, s.direction, falloff, pdf)) return false;
        s.power = light.emission * (falloff / (pdf * s.from.pdf));
        return true;
    }
    if (!(light.versine_zero > 0)) return false;
    const Vec3 local = sample_uniform_cone(u, light.versine_zero);
    s.direction = normalize(Frame::from_normal(light.direction).to_world(local));
    const Real falloff = spot_falloff(light.direction, light.versine_full, light.versine_zero, s.direction);
    s.power = light.emission * (falloff * 2 * pi * light.versine_zero / s.from.pdf);
    return falloff > 0;
}

/// Emits along a direction drawn from the whole image, through a point of the portal. The ray begins outside of the
/// whole scene: objects outside the portal occlude it, as they do for camera paths.
bool LightTable::emit_through_portal(const Light& light, const EmbreeScene& geometry, const Vec2& u_position,
                                     const Vec2& u_direction, EmissionSample& s) const {
    const PortalImage& portal = portal_of(light);
    Real pdf = 0;
    Rgb radiance;
    if (!portal.sample_emission(u_direction, s.from.wi, radiance, pdf)) return false;
    const Real across = portal.density_across(s.from.wi);
    if (!(across > 0)) return false;
    s.from.pdf *= pdf;
    s.from.infinite = true;
    s.direction = -s.from.wi;
    const Vec3 through = portal.point(u_position);
    s.origin = through + s.from.wi * (length(through - geometry.lit_bounds().center()) + covering_radius(geometry));
    s.power = radiance * light.emission * (1 / (s.from.pdf * across));
    return true;
}

EmissionDensity LightTable::emission_density(const LightChooser& chooser, const EmbreeScene& geometry,
                                             const LightSample& at, const Vec3& direction) const {
    const Light& light = lights_[at.light];
    const Real chosen = chooser.probability(Vec3(), at.light);
    if (light.is_area()) {
        const Real cosine = dot(at.target_normal, direction);
        const Real of_direction = light.two_sided ? 0.5f * std::abs(cosine) : std::max(cosine, Real(0));
        const ShapeGeometry& shape = geometry.shapes()[light.shape];
        Real of_point = chosen * static_cast<Real>(density_of_point(light, shape, at.uv));
        if (light.image >= 0) of_point *= image_density(light, shape, at.uv);
        return {of_point, of_direction * inv_pi};
    }
    if (light.kind == LightKind::point) return {chosen, uniform_sphere_pdf()};
    if (light.kind == LightKind::spot && light.image >= 0) return {chosen, stretched_spot(light).pdf(direction)};
    if (light.kind == LightKind::spot)
        return {chosen, versine_between(direction, light.direction) < light.versine_zero
                            ? uniform_cone_pdf(light.versine_zero)
                            : 0.0f};
    if (light.is_at_point()) return {chosen, intensity_of(light).pdf(direction)};
    if (light.kind == LightKind::portal_environment)
        return {chosen * portal_of(light).emission_pdf(-direction), portal_of(light).density_across(-direction)};
    const Real radius = covering_radius(geometry), across = 1 / (pi * radius * radius);
    if (light.kind == LightKind::distant) return {chosen, across};
    return {environment_density(chooser, at.light, Vec3(), -direction), across};
}

Real LightTable::sample_area_point(const EmbreeScene& geometry, const Light& light, Vec2 u, LightSample& s) const {
    if (light.image >= 0) {
        const PixelDistribution::Drawn drawn = images_.points[static_cast<std::size_t>(light.image)].points.sample(u);
        return drawn.density > 0 ? drawn.density * sample_plain_point(geometry, light, drawn.at, s) : Real(0);
    }
    return sample_plain_point(geometry, light, u, s);
}

Real LightTable::sample_plain_point(const EmbreeScene& geometry, const Light& light, const Vec2& u, LightSample& s) {
    if (light.kind == LightKind::triangle) return sample_triangle_point(light, u, s);
    const ShapeGeometry& shape = geometry.shapes()[light.shape];
    if (light.kind == LightKind::patch) return sample_patch_point(light, shape, u, s);
    return sample_quadric_point(shape.quadric, u, s);
}

Vec3 LightTable::some_point(const EmbreeScene& geometry, std::uint32_t light) const {
    LightSample sample;
    sample_plain_point(geometry, lights_[light], {0.5f, 0.5f}, sample);
    return sample.target;
}

bool LightTable::sample_emission(const LightChooser& chooser, const EmbreeScene& geometry, Real u_choice,
                                 Vec2 u_position, Vec2 u_direction, EmissionSample& s) const {
    if (chooser.empty()) return false;
    s = EmissionSample();
    LightSample& from = s.from;
    const LightTree::Chosen chosen = chooser.choose(Vec3(), u_choice, u_position);
    from.light = chosen.light;
    from.pdf = chosen.probability;
    const Light& light = lights_[from.light];
    switch (light.kind) {
        case LightKind::triangle:
        case LightKind::patch:
        case LightKind::quadric:
        case LightKind::sphere:
            if (!emit_from_area(light, sample_area_point(geometry, light, u_position, from), u_direction, s))
                return false;
            if (light.image >= 0) s.power *= shown_at(light, geometry, from.uv);
            return true;
        case LightKind::portal_environment:
            return emit_through_portal(light, geometry, u_position, u_direction, s);
        case LightKind::point:
        case LightKind::spot:
        case LightKind::goniometric:
        case LightKind::projection:
            return emit_from_point(light, u_direction, s);
        case LightKind::distant:
            from.wi = light.direction;
            s.power = light.emission;
            break;
        case LightKind::uniform_environment:
            from.wi = sample_uniform_sphere(u_direction);
            from.pdf *= uniform_sphere_pdf();
            s.power = light.emission;
            break;
        case LightKind::image_environment: {
            Real pdf = 0;
            Rgb radiance;
            if (!environment_of(light).sample(u_direction, from.wi, radiance, pdf)) return false;
            from.pdf *= pdf;
            s.power = radiance * light.emission;
            break;
        }
    }
    const Real radius = covering_radius(geometry);
    const Vec2 d = sample_disk(u_position);
    const Frame frame = Frame::from_normal(from.wi);
    from.infinite = true;
    s.direction = -from.wi;
    s.origin = geometry.lit_bounds().center() + (frame.s * d.x + frame.t * d.y + from.wi) * radius;
    s.power *= pi * radius * radius / from.pdf;
    return true;
}

}  // namespace raylex::transport
