#include "transport/paths/first_hits.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"

namespace raylex::transport {
namespace {

namespace in = geoaovs::inputs;

/// One or three columns, one after the other, so that the pointers stay in registers.
template <class Value>
void fill(std::span<const std::uint32_t> which, std::vector<float> (&columns)[3], Value value) {
    float *x = columns[0].data(), *y = columns[1].data(), *z = columns[2].data();
    for (std::size_t i = 0; i < which.size(); ++i) {
        const auto triple = value(which[i]);
        x[i] = to_float(triple[0]);
        y[i] = to_float(triple[1]);
        z[i] = to_float(triple[2]);
    }
}
template <class Number, class Value>
void fill(std::span<const std::uint32_t> which, std::vector<Number>& column, Value value) {
    Number* const to = column.data();
    for (std::size_t i = 0; i < which.size(); ++i) to[i] = static_cast<Number>(value(which[i]));
}

Vec3 camera_point(const FirstHitSetup& setup, const Vec3& p) {
    Vec3 result;
    for (int r = 0; r < 3; ++r) {
        const Real* m = setup.world_to_camera[r];
        result[r] = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    }
    return result;
}

/// The shading normal after bump and normal maps.
Vec3 plain_normal(const SceneView& scene, const Ray& ray, const Hit& hit, const SurfacePoint& point) {
    if (!scene.materials->turns_normals() || scene.materials->normal_detail(*scene.textures, point).empty())
        return point.shading_normal;
    SurfacePoint before;
    SurfaceSource source;
    scene.geometry->surfaces({&ray, 1}, {&hit, 1}, {&before, 1}, {&source, 1});
    return before.shading_normal;
}

/// Columns that need the details of a surface (EmbreeScene::details), hit by hit.
void describe_details(const PathContext& context, const FirstHits& first, geoaovs::ShadingBatch& batch) {
    const geoaovs::Inputs wanted = context.first_hits.aovs->inputs();
    const std::span<const std::uint32_t> which = first.which;
    const SurfacePoint* const points = first.points.data();
    const EmbreeScene& geometry = *context.scene.geometry;
    for (std::size_t at = 0; at < which.size(); ++at) {
        const std::size_t j = which[at];
        const SurfaceDetails details = geometry.details(first.hits[j], points[j]);
        for (int c = 0; c < 3; ++c) {
            if (wanted & in::dpdv) batch.dpdv[c][at] = to_float(details.dpdv[c]);
            if (wanted & in::object_position) batch.object_position[c][at] = to_float(details.object_position[c]);
        }
        if (wanted & in::curvature) batch.curvature[at] = to_float(details.curvature);
        if (wanted & in::edges)
            batch.edge_pixels[at] =
                to_float(edge_distance(context.first_hits, points[j].position,
                                       {details.edges.data(), 2 * static_cast<std::size_t>(details.edge_count)}));
    }
}

}  // namespace

Real edge_distance(const FirstHitSetup& setup, const Vec3& position, std::span<const Vec3> edges) {
    const Vec3 p = camera_point(setup, position);
    if (!(p.z > 0)) return infinity;
    const auto image = [&](const Vec3& q) {
        return Vec2{(q.x / q.z - p.x / p.z) / setup.pixel_size.x, (q.y / q.z - p.y / p.z) / setup.pixel_size.y};
    };
    // Lines stay lines in a perspective image, so the distance to the edge's image is exact.
    const Real near = Real(1e-3) * p.z;
    Real nearest = infinity;
    for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
        Vec3 a = camera_point(setup, edges[i]), b = camera_point(setup, edges[i + 1]);
        if (a.z < near && b.z < near) continue;
        if (a.z < near) a += (b - a) * ((near - a.z) / (b.z - a.z));
        if (b.z < near) b += (a - b) * ((near - b.z) / (a.z - b.z));
        const Vec2 from = image(a), to = image(b), along{to.x - from.x, to.y - from.y};
        const Real l2 = along.x * along.x + along.y * along.y;
        const Real t = l2 > 0 ? std::clamp(-(from.x * along.x + from.y * along.y) / l2, Real(0), Real(1)) : 0.0f;
        nearest = std::min(nearest, elementary::hypot(from.x + t * along.x, from.y + t * along.y));
    }
    return nearest;
}

void write_first_hits(const PathContext& context, const VertexBatch& v, std::span<const std::uint32_t> which,
                      geoaovs::ShadingBatch& batch, display::DisplayServices& display) {
    if (context.first_hits.aovs->inputs() == 0 || which.empty()) return;
    describe_first_hits(context, {which, v.rows, v.rays, v.hits, v.points, v.sources, v.bsdfs}, batch);
    context.first_hits.aovs->write(batch, display);
}

void describe_first_hits(const PathContext& context, const FirstHits& first, geoaovs::ShadingBatch& batch) {
    const geoaovs::Inputs wanted = context.first_hits.aovs->inputs();
    const std::span<const std::uint32_t> which = first.which;
    const SurfacePoint* const points = first.points.data();
    const EmbreeScene& geometry = *context.scene.geometry;
    batch.resize(static_cast<int>(which.size()), wanted);
    std::copy(&context.first_hits.world_to_camera[0][0], &context.first_hits.world_to_camera[0][0] + 12,
              &batch.world_to_camera[0][0]);
    const DVec3& origin = geometry.space().origin;
    batch.origin[0] = origin.x, batch.origin[1] = origin.y, batch.origin[2] = origin.z;
    fill(which, batch.row, [&](std::size_t j) { return static_cast<std::int32_t>(first.rows[j]); });
    if (wanted & in::position) fill(which, batch.position, [&](std::size_t j) { return points[j].position; });
    if (wanted & in::shading_normal)
        fill(which, batch.shading_normal,
             [&](std::size_t j) { return face_forward(points[j].shading_normal, points[j].wo); });
    if (wanted & in::plain_normal)
        fill(which, batch.plain_normal, [&](std::size_t j) {
            return face_forward(plain_normal(context.scene, first.rays[j], first.hits[j], points[j]), points[j].wo);
        });
    if (wanted & in::geometric_normal)
        fill(which, batch.geometric_normal,
             [&](std::size_t j) { return face_forward(points[j].geometric_normal, points[j].wo); });
    if (wanted & in::view) fill(which, batch.view, [&](std::size_t j) { return points[j].wo; });
    if (wanted & in::texture) {
        fill(which, batch.s, [&](std::size_t j) { return points[j].u; });
        fill(which, batch.t, [&](std::size_t j) { return points[j].v; });
    }
    if (wanted & in::parameters) {
        fill(which, batch.u, [&](std::size_t j) { return first.hits[j].u; });
        fill(which, batch.v, [&](std::size_t j) { return first.hits[j].v; });
    }
    if (wanted & in::dpdu) fill(which, batch.dpdu, [&](std::size_t j) { return points[j].dpdu; });
    if (wanted & in::outside_ior)
        fill(which, batch.outside_ior, [&](std::size_t j) {
            return dot(points[j].geometric_normal, points[j].wo) < 0 ? first.bsdfs[j].inside_ior() : 1.0f;
        });
    if (wanted & in::ids) {
        fill(which, batch.object_id, [&](std::size_t j) { return first.sources[j].object_id; });
        fill(which, batch.part_id, [&](std::size_t j) {
            const Hit& hit = first.hits[j];
            return hit.instance == Hit::none
                       ? 0
                       : static_cast<std::int32_t>(hit.shape - geometry.instances()[hit.instance].first_shape + 1);
        });
        fill(which, batch.surface_id, [&](std::size_t j) { return geometry.surface_number(first.hits[j]); });
    }
    if (wanted & in::albedo)
        fill(which, batch.albedo, [&](std::size_t j) { return first.bsdfs[j].albedo(points[j].wo); });
    if (wanted & (in::dpdv | in::object_position | in::curvature | in::edges)) describe_details(context, first, batch);
}

}  // namespace raylex::transport
