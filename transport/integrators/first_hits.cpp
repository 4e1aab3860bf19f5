#include "transport/integrators/first_hits.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

namespace in = geoaovs::inputs;

template <class Triple>
void put(std::vector<float> (&columns)[3], std::size_t at, const Triple& value) {
    for (int c = 0; c < 3; ++c) columns[c][at] = value[c];
}

Vec3 camera_point(const IntegratorContext& context, const Vec3& p) {
    Vec3 result;
    for (int r = 0; r < 3; ++r) {
        const float* m = context.world_to_camera[r];
        result[r] = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    }
    return result;
}

}  // namespace

float edge_distance(const IntegratorContext& context, const Vec3& position, std::span<const Vec3> edges) {
    const Vec3 p = camera_point(context, position);
    if (!(p.z > 0)) return infinity;
    const auto image = [&](const Vec3& q) {
        return Vec2{(q.x / q.z - p.x / p.z) / context.pixel_size.x, (q.y / q.z - p.y / p.z) / context.pixel_size.y};
    };
    // Lines stay lines in a perspective image, so the distance to the edge's image is exact.
    const float near = 1e-3f * p.z;
    float nearest = infinity;
    for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
        Vec3 a = camera_point(context, edges[i]), b = camera_point(context, edges[i + 1]);
        if (a.z < near && b.z < near) continue;
        if (a.z < near) a += (b - a) * ((near - a.z) / (b.z - a.z));
        if (b.z < near) b += (a - b) * ((near - b.z) / (a.z - b.z));
        const Vec2 from = image(a), to = image(b), along{to.x - from.x, to.y - from.y};
        const float l2 = along.x * along.x + along.y * along.y;
        const float t = l2 > 0 ? std::clamp(-(from.x * along.x + from.y * along.y) / l2, 0.0f, 1.0f) : 0.0f;
        nearest = std::min(nearest, std::hypot(from.x + t * along.x, from.y + t * along.y));
    }
    return nearest;
}

void add_first_hit(const IntegratorContext& context, const FirstHit& first, geoaovs::ShadingBatch& batch) {
    const geoaovs::Inputs wanted = context.aovs->inputs();
    const SurfacePoint& point = *first.point;
    const auto at = static_cast<std::size_t>(batch.count++);
    batch.row[at] = first.row;
    if (wanted & in::position) put(batch.position, at, point.position);
    // No material bends its normal yet (normal maps are refused), so the shading normal is the plain one.
    if (wanted & in::shading_normal) put(batch.shading_normal, at, face_forward(point.shading_normal, point.wo));
    if (wanted & in::plain_normal) put(batch.plain_normal, at, face_forward(point.shading_normal, point.wo));
    if (wanted & in::geometric_normal) put(batch.geometric_normal, at, face_forward(point.geometric_normal, point.wo));
    if (wanted & in::view) put(batch.view, at, point.wo);
    if (wanted & in::texture) {
        batch.s[at] = point.u;
        batch.t[at] = point.v;
    }
    if (wanted & in::parameters) {
        batch.u[at] = first.hit->u;
        batch.v[at] = first.hit->v;
    }
    if (wanted & in::dpdu) put(batch.dpdu, at, point.dpdu);
    if (wanted & in::outside_ior)
        batch.outside_ior[at] = dot(point.geometric_normal, point.wo) < 0 ? first.bsdf->inside_ior() : 1.0f;
    if (wanted & in::ids) {
        const EmbreeScene& geometry = *context.scene.geometry;
        const bool instanced = first.hit->instance != Hit::none;
        batch.object_id[at] = first.source->object_id;
        batch.part_id[at] = instanced ? static_cast<std::int32_t>(
                                            first.hit->shape - geometry.instances()[first.hit->instance].first_shape + 1)
                                      : 0;
        batch.surface_id[at] = geometry.surface_number(*first.hit);
    }
    if (wanted & in::albedo) put(batch.albedo, at, first.bsdf->albedo(point.wo));
    if (!(wanted & (in::dpdv | in::object_position | in::curvature | in::edges))) return;
    const SurfaceDetails details = context.scene.geometry->details(*first.hit, point);
    if (wanted & in::dpdv) put(batch.dpdv, at, details.dpdv);
    if (wanted & in::object_position) put(batch.object_position, at, details.object_position);
    if (wanted & in::curvature) batch.curvature[at] = details.curvature;
    if (wanted & in::edges)
        batch.edge_pixels[at] = edge_distance(
            context, point.position, {details.edges.data(), 2 * static_cast<std::size_t>(details.edge_count)});
}

}  // namespace raylex::transport
