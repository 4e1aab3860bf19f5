#include "transport/geometry/shapes/placed_mesh.h"

namespace raylex::transport {
namespace {

/// Whether twice the area is exactly 0. In double, differences of float coordinates and their products are exact unless
/// magnitudes differ by more than 2^29, so a thin triangle does not count as degenerate.
bool has_no_area(const StoredVec3& a, const StoredVec3& b, const StoredVec3& c) {
    const double ux = double(b.x) - a.x, uy = double(b.y) - a.y, uz = double(b.z) - a.z;
    const double vx = double(c.x) - a.x, vy = double(c.y) - a.y, vz = double(c.z) - a.z;
    return uy * vz - uz * vy == 0 && uz * vx - ux * vz == 0 && ux * vy - uy * vx == 0;
}

}  // namespace

std::size_t drop_faces_without_area(ShapeKind kind, const std::vector<StoredVec3>& positions,
                                    std::vector<std::uint32_t>& indices) {
    const std::size_t group = kind == ShapeKind::triangle_mesh ? 3 : 4;
    std::size_t kept = 0;
    for (std::size_t i = 0; i + group <= indices.size(); i += group) {
        const std::uint32_t* k = indices.data() + i;
        const auto p = [&](std::size_t corner) -> const StoredVec3& { return positions[k[corner]]; };
        const bool degenerate =
            group == 3 ? has_no_area(p(0), p(1), p(2)) : has_no_area(p(0), p(1), p(2)) && has_no_area(p(1), p(3), p(2));
        if (degenerate) continue;
        if (kept != i)
            for (std::size_t c = 0; c < group; ++c) indices[kept + c] = k[c];
        kept += group;
    }
    const std::size_t dropped = (indices.size() - kept) / group;
    indices.resize(kept);
    return dropped;
}

Result<PlacedMesh> place_mesh(const SceneShape& shape, const Transform& placement) {
    if (!placement.invertible()) return error_at(shape.location, "the shape's transform has no inverse");
    PlacedMesh mesh;
    mesh.positions = shape.positions;
    mesh.normals = shape.normals;
    mesh.indices = shape.indices;
    if (!placement.is_identity()) {
        for (StoredVec3& p : mesh.positions) p = to_float(placement.point_in_double(p));
        for (StoredVec3& n : mesh.normals) n = to_float(placement.normal(n));
    }
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        if (!is_finite(mesh.positions[i]) || (!mesh.normals.empty() && !is_finite(mesh.normals[i])))
            return error_at(shape.location, "vertex " + std::to_string(i) +
                                                " is not finite after the current transformation" +
                                                (shape.source_file.empty() ? "" : " (" + mesh_name(shape) + ")"));
    mesh.dropped = drop_faces_without_area(shape.kind, mesh.positions, mesh.indices);
    return mesh;
}

std::string mesh_name(const SceneShape& shape) {
    return shape.source_file.empty() ? "the mesh" : "'" + shape.source_file + "'";
}

}  // namespace raylex::transport
