#include "transport/paths/subpaths/transmittance.h"

#include <algorithm>

namespace raylex::transport {

Real emitter_opacity(const SceneView& scene, const LightSample& sample, const Vec3& from) {
    const Light& light = scene.lights->lights()[sample.light];
    if (!light.is_area() || light.hidden) return 1;
    const ShapeGeometry& shape = scene.geometry->shapes()[light.shape];
    if (shape.alpha < 0 || shape.interface) return 1;
    Ray ray[1];
    ray[0].origin = from;
    ray[0].direction = sample.target - from;
    const Hit hit[1] = {{1, sample.uv.x, sample.uv.y, light.shape, light.primitive, Hit::none, 0, {}}};
    SurfacePoint point[1];
    SurfaceSource source[1];
    scene.geometry->surfaces(ray, hit, point, source);
    return scene.opacity(shape, point[0]);
}

Real pass_through_transmittance(const PassThroughRay& walk, Ray ray, Real visible, std::int32_t medium,
                                display::Tracker& tracker, Rgb& through) {
    const EmbreeScene& geometry = *walk.scene.geometry;
    const bool finite_end = ray.t_max < infinity;
    const Vec3 end = ray.origin + ray.direction;
    FlightNumbers numbers = walk.numbers;
    for (;;) {
        Hit hit;
        if (walk.scene.tests_alpha()) {
            geometry.intersect_alpha(ray, hit);
            ++walk.counters.shadow_rays;
        }
        if (medium >= 0) {
            const Real whole = finite_end ? length(ray.direction) : infinity;
            const Real distance = !hit.valid() ? whole : finite_end ? hit.t * whole : hit.t;
            const Medium& crossed = (*walk.scene.media)[medium];
            if (crossed.grid != nullptr)
                through *= crossed.grid->transmittance(
                    {ray.origin, finite_end ? ray.direction / whole : ray.direction, distance}, numbers.row());
            else through *= transmittance(crossed, distance);
        }
        if (!hit.valid()) return visible;
        const Hit hits[1] = {hit};
        const Ray rays[1] = {ray};
        SurfacePoint point[1];
        SurfaceSource source[1];
        geometry.surfaces(rays, hits, point, source);
        const ShapeGeometry& shape = geometry.shapes()[hit.shape];
        visible *= 1 - walk.scene.opacity(shape, point[0]);
        if (visible > 0) walk.record.pass_through(tracker, source[0].label);
        else if (!walk.to_the_end) return 0;
        if (shape.border) medium = shape.medium_towards(point[0].geometric_normal, ray.direction, medium);
        ray.origin =
            straight_ray_origin(ray, hit.t, point[0].position, point[0].geometric_normal, source[0].offset.here);
        if (finite_end) {
            const Vec3 rest = end - ray.origin;
            if (!(dot(rest, ray.direction) > 0)) return visible;
            ray.direction = rest;
        }
    }
}

namespace {

std::int32_t follow_media(const SceneView& scene, Ray ray, const Vec3* end) {
    const EmbreeScene& geometry = *scene.geometry;
    std::int32_t medium = scene.media->camera();
    for (;;) {
        const Ray rays[1] = {ray};
        Hit hits[1];
        geometry.intersect(rays, hits);
        if (!hits[0].valid()) return medium;
        SurfacePoint point[1];
        SurfaceSource source[1];
        geometry.surfaces(rays, hits, point, source);
        medium = geometry.shapes()[hits[0].shape].medium_towards(point[0].geometric_normal, ray.direction, medium);
        ray.origin =
            straight_ray_origin(ray, hits[0].t, point[0].position, point[0].geometric_normal, source[0].offset.here);
        if (end == nullptr) continue;
        const Vec3 rest = *end - ray.origin;
        if (!(dot(rest, ray.direction) > 0)) return medium;
        ray.direction = rest;
    }
}

}  // namespace

std::int32_t medium_at(const SceneView& scene, const Vec3& camera, const Vec3& point) {
    Ray ray;
    ray.origin = camera;
    ray.direction = point - camera;
    ray.t_max = end_of_segment;  // of a light that stands on no border: its own surface changes nothing
    if (!(length_squared(ray.direction) > 0)) return scene.media->camera();
    return follow_media(scene, ray, &point);
}

std::int32_t medium_far_away(const SceneView& scene, const Vec3& camera, const Vec3& direction) {
    Ray ray;
    ray.origin = camera;
    ray.direction = direction;
    return follow_media(scene, ray, nullptr);
}

std::vector<std::int32_t> media_of_lights(const SceneView& scene, const Vec3& camera) {
    std::vector<std::int32_t> media;
    if (!scene.media->any()) return media;
    const std::span<const Light> lights = scene.lights->lights();
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
        const Light& light = lights[i];
        if (light.is_area()) {
            const ShapeGeometry& shape = scene.geometry->shapes()[light.shape];
            const bool border = shape.inside_medium != shape.outside_medium;
            media.push_back(border ? -1 : medium_at(scene, camera, scene.lights->some_point(*scene.geometry, i)));
        } else if (light.is_at_point()) {
            media.push_back(medium_at(scene, camera, light.position));
        } else {
            media.push_back(
                medium_far_away(scene, camera, light.kind == LightKind::distant ? light.direction : Vec3{0, 0, 1}));
        }
    }
    return media;
}

}  // namespace raylex::transport
