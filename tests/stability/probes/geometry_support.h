// Shared code of geometry probes: small scenes in code, rays, and their hits.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "display/services/split_mix.h"
#include "experiments/stability/probe.h"
#include "transport/embree/embree_scene.h"
#include "transport/math/sampling.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::experiments::geometry_probe {

using namespace transport;

/// Reproducible uniform numbers.
class RandomNumbers {
  public:
    explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
    Real operator()() { return unit_float(mix_bits(state_ += golden_gamma)); }
    Real signed_unit() { return 2 * (*this)() - 1; }
    Vec3 direction() { return sample_uniform_sphere({(*this)(), (*this)()}); }
    Vec3 point(Real extent) { return {extent * signed_unit(), extent * signed_unit(), extent * signed_unit()}; }
    std::size_t below(std::size_t n) { return std::min(n - 1, static_cast<std::size_t>((*this)() * Real(n))); }

  private:
    std::uint64_t state_;
};

inline Result<EmbreeScene> geometry_of(std::vector<SceneShape> shapes, const std::optional<Transform>& instance = {}) {
    SceneDescription scene;
    SceneEntity material;
    material.type = "diffuse";
    scene.materials.push_back(material);
    for (SceneShape& shape : shapes) shape.material = 0;
    if (instance) {
        scene.objects.push_back({"object", std::move(shapes)});
        SceneInstance placed;
        placed.object = 0;
        placed.to_world = *instance;
        scene.instances.push_back(placed);
    } else {
        scene.shapes = std::move(shapes);
    }
    TextureTable textures;
    return EmbreeScene::build(scene, textures, {});
}

struct Found {
    Hit hit;
    SurfacePoint point;
    SurfaceSource source;
};
inline Found find(const EmbreeScene& scene, const Ray& ray) {
    Found f;
    scene.intersect({&ray, 1}, {&f.hit, 1});
    if (f.hit.valid()) scene.surfaces({&ray, 1}, {&f.hit, 1}, {&f.point, 1}, {&f.source, 1});
    return f;
}
inline Ray ray_from(const Vec3& origin, const Vec3& direction) {
    Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    return ray;
}
inline Ray leaving(const Found& from, const Vec3& direction) {
    return ray_from(
        offset_ray_origin(from.point.position, from.point.geometric_normal, from.source.offset.here, direction),
        direction);
}

inline StoredVec3 stored(const DVec3& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// Returns the result for an event that must never occur: its count, with the expected value 0.
inline ProbeResult never(std::uint64_t count, std::string note = {}) {
    ProbeResult result;
    result.measured = static_cast<double>(count);
    result.expected = 0;
    result.note = std::move(note);
    return result;
}

}  // namespace raylex::experiments::geometry_probe
