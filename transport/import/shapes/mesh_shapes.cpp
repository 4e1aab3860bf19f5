#include "transport/import/shapes/mesh_shapes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "transport/files/ply.h"
#include "transport/geometry/shapes/placed_mesh.h"
#include "transport/import/shapes/shape_parameters.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

namespace {

/// Warns that the number of per-vertex values differs from the number of vertices: pbrt-v4 ignores them all.
void warn_uneven(const ParameterSet& set, const std::string& name, const std::string& found, std::size_t vertices,
                 std::vector<Error>& warnings) {
    warnings.push_back(error_at(location_of(set, name), "'" + name + "' has " + found + " for " +
                                                            std::to_string(vertices) +
                                                            " vertices; expected as many, and all are ignored"));
}

Result<std::vector<StoredVec2>> uvs_of(const ParameterSet& set, std::size_t vertices, std::vector<Error>& warnings) {
    const Result<std::span<const double>> numbers = array_of(set, "uv", ParameterType::point2, "point2");
    if (!numbers) return numbers.error();
    if (!numbers->empty() && numbers->size() != 2 * vertices) {
        warn_uneven(set, "uv", std::to_string(numbers->size() / 2) + " points", vertices, warnings);
        return std::vector<StoredVec2>();
    }
    std::vector<StoredVec2> uvs(numbers->size() / 2);
    for (std::size_t i = 0; i < uvs.size(); ++i) {
        uvs[i] = {static_cast<float>((*numbers)[2 * i]), static_cast<float>((*numbers)[2 * i + 1])};
        if (!std::isfinite(uvs[i].x) || !std::isfinite(uvs[i].y))
            return error_at(location_of(set, "uv"),
                            "'uv' of vertex " + std::to_string(i) + " is beyond the range of float");
    }
    return uvs;
}

Result<std::vector<StoredVec3>> normals_of(const ParameterSet& set, std::size_t vertices,
                                           std::vector<Error>& warnings) {
    Result<std::vector<StoredVec3>> normals = triples(set, "N", ParameterType::normal, "normal");
    if (normals && !normals->empty() && normals->size() != vertices) {
        warn_uneven(set, "N", std::to_string(normals->size()) + " normals", vertices, warnings);
        normals->clear();
    }
    return normals;
}

/// Repairs normals. Public meshes contain normals that are zero or not finite, mostly at vertices whose faces have no
/// area. Such a normal becomes the area-weighted mean of the faces around the vertex, each turned to the side of the
/// normals at its other corners (some files have faces with the opposite orientation). Without faces of positive area
/// it is arbitrary, since no ray hits there.
std::size_t repair_normals(std::vector<StoredVec3>& normals, const std::vector<StoredVec3>& positions,
                           const std::vector<std::uint32_t>& triangles, const std::vector<std::uint32_t>& quads) {
    std::vector<std::uint8_t> broken(normals.size(), 0);
    std::size_t count = 0;
    for (std::size_t i = 0; i < normals.size(); ++i)
        if (!is_finite(normals[i]) || normals[i] == StoredVec3()) broken[i] = 1, ++count;
    if (count == 0) return 0;
    std::vector<DVec3> sums(normals.size());
    const auto add_faces = [&](const std::vector<std::uint32_t>& indices, std::size_t group) {
        for (std::size_t i = 0; i + group <= indices.size(); i += group) {
            const std::uint32_t* k = indices.data() + i;
            if (!std::any_of(k, k + group, [&](std::uint32_t vertex) { return broken[vertex] != 0; })) continue;
            const DVec3 a(positions[k[0]]), b(positions[k[1]]), c(positions[k[2]]);
            DVec3 normal = cross(b - a, c - a), side;
            for (std::size_t corner = 0; corner < group; ++corner)
                if (broken[k[corner]] == 0) side = side + DVec3(normals[k[corner]]);
            if (dot(normal, side) < 0) normal = normal * -1;
            for (std::size_t corner = 0; corner < group; ++corner) sums[k[corner]] = sums[k[corner]] + normal;
        }
    };
    add_faces(triangles, 3);
    add_faces(quads, 4);
    for (std::size_t i = 0; i < normals.size(); ++i) {
        if (broken[i] == 0) continue;
        const double length = std::sqrt(dot(sums[i], sums[i]));
        normals[i] =
            length > 0 && std::isfinite(length) ? to_float((sums[i] * (1 / length)).to_real()) : StoredVec3{0, 0, 1};
    }
    return count;
}

void warn_repaired(std::size_t count, const SceneShape& shape, const std::string& what, std::vector<Error>& warnings) {
    if (count > 0)
        warnings.push_back(error_at(shape.location, std::to_string(count) + " of the normals of " + what +
                                                        " are zero or not finite and were computed from the faces"));
}

/// Sets the transform, and the normals and the side that ReverseOrientation turns.
void take_context(SceneShape& shape, const ShapeContext& context) {
    shape.object_to_world = context.object_to_world;
    shape.flip_normal = context.reverse_orientation != context.object_to_world.swaps_handedness();
    if (context.reverse_orientation)
        for (StoredVec3& n : shape.normals) n = -n;
}

std::size_t drop_degenerate(SceneShape& shape) {
    return drop_faces_without_area(shape.kind, shape.positions, shape.indices);
}

void warn_dropped(std::size_t dropped, const SceneShape& shape, const std::string& what, std::vector<Error>& warnings) {
    if (dropped > 0)
        warnings.push_back(error_at(
            shape.location, std::to_string(dropped) + " of the faces of " + what + " have no area and are left out"));
}

/// Reads `displacement` and `edgelength` of a plymesh. Displaced quadrilaterals become triangles, as in pbrt.
Status read_displacement(const ParameterSet& set, PlyMesh& mesh, SceneShape& shape) {
    // pbrt's documentation and its source spell the name differently.
    const char* const name = set.find("displacement.edgelength") != nullptr ? "displacement.edgelength" : "edgelength";
    const Result<double> edge = set.real_or(name, 1);
    if (!edge) return edge.error();
    shape.edge_length = static_cast<Real>(*edge);
    if (!(shape.edge_length > 0) || !std::isfinite(shape.edge_length))
        return error_at(location_of(set, name), "'edgelength' is not above 0; expected a length in the world");
    const Parameter* displacement = set.find("displacement");
    if (displacement == nullptr) return success();
    if (displacement->type != ParameterType::texture || displacement->strings.size() != 1)
        return error_at(displacement->location,
                        "'displacement' has the wrong type; expected one \"texture displacement\"");
    if (mesh.uvs.empty())
        return error_at(displacement->location, mesh_name(shape) +
                                                    " has no texture coordinates; expected them for its "
                                                    "displacement (pbrt-v4 requires them, too)");
    shape.displacement_texture = displacement->strings.front();
    for (std::size_t i = 0; i + 4 <= mesh.quads.size(); i += 4) {
        const std::uint32_t* q = mesh.quads.data() + i;
        mesh.triangles.insert(mesh.triangles.end(), {q[0], q[1], q[3], q[0], q[3], q[2]});
    }
    mesh.quads.clear();
    return success();
}

/// The common part of both kinds of inline mesh.
Result<std::vector<SceneShape>> make_inline_mesh(ShapeKind kind, const ParameterSet& set, const ShapeContext& context,
                                                 std::vector<Error>& warnings) {
    SceneShape shape;
    shape.kind = kind;
    shape.location = set.location;
    Result<std::vector<StoredVec3>> positions = triples(set, "P", ParameterType::point3, "point3");
    if (!positions) return positions.error();
    if (positions->empty()) return error_at(set.location, "mesh has no vertices; expected \"point3 P\"");
    shape.positions = std::move(*positions);
    const std::size_t group = kind == ShapeKind::triangle_mesh ? 3 : 4;
    Result<std::vector<std::uint32_t>> indices = indices_of(set, shape.positions.size(), group, warnings);
    if (!indices) return indices.error();
    shape.indices = std::move(*indices);
    Result<std::vector<StoredVec2>> uvs = uvs_of(set, shape.positions.size(), warnings);
    if (!uvs) return uvs.error();
    shape.uvs = std::move(*uvs);
    Result<std::vector<StoredVec3>> normals = normals_of(set, shape.positions.size(), warnings);
    if (!normals) return normals.error();
    shape.normals = std::move(*normals);
    return finish_mesh(std::move(shape), "the mesh", context, warnings);
}

}  // namespace

Result<std::vector<SceneShape>> finish_mesh(SceneShape mesh, const std::string& what, const ShapeContext& context,
                                            std::vector<Error>& warnings) {
    const bool patches = mesh.kind == ShapeKind::bilinear_mesh;
    const std::vector<std::uint32_t> none;
    const std::size_t repaired =
        repair_normals(mesh.normals, mesh.positions, patches ? none : mesh.indices, patches ? mesh.indices : none);
    warn_repaired(repaired, mesh, what, warnings);
    take_context(mesh, context);
    warn_dropped(drop_degenerate(mesh), mesh, what, warnings);
    std::vector<SceneShape> shapes;
    if (!mesh.indices.empty()) shapes.push_back(std::move(mesh));
    return shapes;
}

Result<std::vector<SceneShape>> make_triangle_mesh(const ParameterSet& set, const ShapeContext& context,
                                                   std::vector<Error>& warnings) {
    return make_inline_mesh(ShapeKind::triangle_mesh, set, context, warnings);
}

Result<std::vector<SceneShape>> make_bilinear_mesh(const ParameterSet& set, const ShapeContext& context,
                                                   std::vector<Error>& warnings) {
    // for pbrt's light sampling only: raylex samples by the image of the light itself
    static_cast<void>(set.find("emissionfilename"));
    return make_inline_mesh(ShapeKind::bilinear_mesh, set, context, warnings);
}

Result<std::vector<SceneShape>> make_ply_mesh(const ParameterSet& set, const ShapeContext& context,
                                              std::vector<Error>& warnings) {
    const Result<std::string> name = set.string_or("filename", "");
    if (!name) return name.error();
    const SourceLocation& where = location_of(set, "filename");
    if (name->empty()) return error_at(where, "plymesh without a file; expected \"string filename\"");
    const Result<std::string> path = context.search.find(*name, where);
    if (!path) return path.error();
    Result<PlyMesh> mesh = read_ply(*path);
    if (!mesh) return named_by(mesh.error(), "the plymesh", where);

    SceneShape base;
    base.location = set.location;
    base.source_file = std::filesystem::path(*name).filename().string();
    if (Status status = read_displacement(set, *mesh, base); !status) return status.error();
    base.positions = std::move(mesh->positions);
    base.normals = std::move(mesh->normals);
    base.uvs = std::move(mesh->uvs);
    const std::string shown = mesh_name(base);
    warn_repaired(repair_normals(base.normals, base.positions, mesh->triangles, mesh->quads), base, shown, warnings);
    if (mesh->odd_faces > 0)
        warnings.push_back(error_at(base.location, std::to_string(mesh->odd_faces) + " of the faces of " + shown +
                                                       " have neither 3 nor 4 vertices and are left out, as in "
                                                       "pbrt-v4"));
    if (mesh->broken_uvs > 0)
        warnings.push_back(error_at(base.location, std::to_string(mesh->broken_uvs) +
                                                       " of the texture coordinates of " + shown +
                                                       " are not finite and were set to 0"));
    take_context(base, context);
    std::size_t dropped = 0;
    std::vector<SceneShape> shapes;
    const bool both = !mesh->quads.empty() && !mesh->triangles.empty();
    if (!mesh->quads.empty()) {
        SceneShape quads = base;
        quads.kind = ShapeKind::bilinear_mesh;
        quads.indices = std::move(mesh->quads);
        dropped += drop_degenerate(quads);
        shapes.push_back(std::move(quads));
    }
    if (both || shapes.empty()) {
        base.indices = std::move(mesh->triangles);
        dropped += drop_degenerate(base);
        shapes.push_back(std::move(base));
    }
    warn_dropped(dropped, shapes.front(), mesh_name(shapes.front()), warnings);
    std::erase_if(shapes, [](const SceneShape& shape) { return shape.indices.empty(); });
    return shapes;
}

}  // namespace raylex::transport
