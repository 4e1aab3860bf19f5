#include "transport/import/mesh_shapes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "transport/geometry/matrix34.h"
#include "transport/geometry/placed_mesh.h"
#include "transport/import/ply.h"

namespace raylex::transport {

namespace {

/// The values of an array parameter, or an Error when it has another type. Absent: no values.
Result<std::vector<double>> array_of(const ParameterSet& set, std::string_view name, ParameterType type,
                                     const char* type_name) {
    const Parameter* parameter = set.find(name);
    if (parameter == nullptr) return std::vector<double>();
    if (parameter->type != type)
        return error_at(parameter->location, "mesh parameter '" + std::string(name) +
                                                 "' has the wrong type; expected \"" + type_name + " " +
                                                 std::string(name) + "\"");
    return parameter->numbers;
}

const SourceLocation& location_of(const ParameterSet& set, std::string_view name) {
    const Parameter* parameter = set.find(name);
    return parameter != nullptr ? parameter->location : set.location;
}

Result<std::vector<StoredVec3>> triples(const ParameterSet& set, std::string_view name, ParameterType type,
                                        const char* type_name) {
    const Result<std::vector<double>> numbers = array_of(set, name, type, type_name);
    if (!numbers) return numbers.error();
    std::vector<StoredVec3> result(numbers->size() / 3);
    for (std::size_t i = 0; i < result.size(); ++i) {
        const double* n = numbers->data() + 3 * i;
        result[i] = {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
        if (!is_finite(result[i]) && type != ParameterType::normal)
            return error_at(location_of(set, name), "vertex " + std::to_string(i) + " of '" + std::string(name) +
                                                        "' is beyond the range of float");
    }
    return result;
}

/// Indices of `group` per primitive, checked against `vertices`; 0 1 2 ... when absent and there is one primitive.
Result<std::vector<std::uint32_t>> indices_of(const ParameterSet& set, std::size_t vertices, std::size_t group) {
    const Result<std::vector<double>> numbers = array_of(set, "indices", ParameterType::integer, "integer");
    if (!numbers) return numbers.error();
    std::vector<std::uint32_t> indices;
    if (numbers->empty()) {
        if (vertices != group)
            return error_at(set.location, "mesh of " + std::to_string(vertices) +
                                              " vertices has no \"integer indices\"; expected them, or exactly " +
                                              std::to_string(group) + " vertices");
        for (std::size_t i = 0; i < group; ++i) indices.push_back(static_cast<std::uint32_t>(i));
        return indices;
    }
    const SourceLocation& where = location_of(set, "indices");
    if (numbers->size() % group != 0)
        return error_at(where, "'indices' has " + std::to_string(numbers->size()) + " values; expected a multiple of " +
                                   std::to_string(group));
    indices.reserve(numbers->size());
    for (std::size_t i = 0; i < numbers->size(); ++i) {
        const double value = (*numbers)[i];
        if (value < 0 || value >= static_cast<double>(vertices))
            return error_at(where, "index " + std::to_string(static_cast<std::int64_t>(value)) + " (value " +
                                       std::to_string(i) + " of 'indices') is out of range; expected 0 to " +
                                       std::to_string(static_cast<std::int64_t>(vertices) - 1));
        indices.push_back(static_cast<std::uint32_t>(value));
    }
    return indices;
}

Result<std::vector<StoredVec2>> uvs_of(const ParameterSet& set, std::size_t vertices) {
    const Result<std::vector<double>> numbers = array_of(set, "uv", ParameterType::point2, "point2");
    if (!numbers) return numbers.error();
    if (!numbers->empty() && numbers->size() != 2 * vertices)
        return error_at(location_of(set, "uv"), "'uv' has " + std::to_string(numbers->size() / 2) + " points for " +
                                                    std::to_string(vertices) + " vertices; expected as many");
    std::vector<StoredVec2> uvs(numbers->size() / 2);
    for (std::size_t i = 0; i < uvs.size(); ++i) {
        uvs[i] = {static_cast<float>((*numbers)[2 * i]), static_cast<float>((*numbers)[2 * i + 1])};
        if (!std::isfinite(uvs[i].x) || !std::isfinite(uvs[i].y))
            return error_at(location_of(set, "uv"),
                            "'uv' of vertex " + std::to_string(i) + " is beyond the range of float");
    }
    return uvs;
}

Result<std::vector<StoredVec3>> normals_of(const ParameterSet& set, std::size_t vertices) {
    Result<std::vector<StoredVec3>> normals = triples(set, "N", ParameterType::normal, "normal");
    if (normals && !normals->empty() && normals->size() != vertices)
        return error_at(location_of(set, "N"), "'N' has " + std::to_string(normals->size()) + " normals for " +
                                                   std::to_string(vertices) + " vertices; expected as many");
    return normals;
}

/// Public meshes hold normals that are not finite numbers, mostly at vertices whose faces have no area. Such a normal
/// becomes the mean of the faces around the vertex by area, or any direction where there is none: no light falls there.
std::size_t repair_normals(std::vector<StoredVec3>& normals, const std::vector<StoredVec3>& positions,
                           const std::vector<std::uint32_t>& triangles, const std::vector<std::uint32_t>& quads) {
    std::vector<std::uint8_t> broken(normals.size(), 0);
    std::size_t count = 0;
    for (std::size_t i = 0; i < normals.size(); ++i)
        if (!is_finite(normals[i])) broken[i] = 1, ++count;
    if (count == 0) return 0;
    std::vector<DVec3> sums(normals.size());
    const auto add_faces = [&](const std::vector<std::uint32_t>& indices, std::size_t group) {
        for (std::size_t i = 0; i + group <= indices.size(); i += group) {
            const std::uint32_t* k = indices.data() + i;
            if (!std::any_of(k, k + group, [&](std::uint32_t vertex) { return broken[vertex] != 0; })) continue;
            const DVec3 a(positions[k[0]]), b(positions[k[1]]), c(positions[k[2]]);
            const DVec3 normal = cross(b - a, c - a);
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
                                                        " are not finite numbers and were computed from the faces"));
}

/// The transform, and what ReverseOrientation turns.
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

/// What both kinds of inline mesh share.
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
    Result<std::vector<std::uint32_t>> indices = indices_of(set, shape.positions.size(), group);
    if (!indices) return indices.error();
    shape.indices = std::move(*indices);
    Result<std::vector<StoredVec2>> uvs = uvs_of(set, shape.positions.size());
    if (!uvs) return uvs.error();
    shape.uvs = std::move(*uvs);
    Result<std::vector<StoredVec3>> normals = normals_of(set, shape.positions.size());
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
    if (const Parameter* image = set.find("emissionfilename"))
        return error_at(image->location,
                        "'emissionfilename' is not supported yet; the patch would emit the wrong light");
    return make_inline_mesh(ShapeKind::bilinear_mesh, set, context, warnings);
}

Result<std::vector<SceneShape>> make_ply_mesh(const ParameterSet& set, const ShapeContext& context,
                                              std::vector<Error>& warnings) {
    const Result<std::string> name = set.string_or("filename", "");
    if (!name) return name.error();
    const SourceLocation& where = location_of(set, "filename");
    if (name->empty()) return error_at(where, "plymesh without a file; expected \"string filename\"");
    if (const Parameter* displacement = set.find("displacement"))
        return error_at(displacement->location,
                        "displacement of meshes is not supported yet; the surface would be wrong");
    const Result<std::string> path = context.search.find(*name, where);
    if (!path) return path.error();
    Result<PlyMesh> mesh = read_ply(*path);
    if (!mesh) {
        Error error = mesh.error();
        error.hint += (error.hint.empty() ? "" : "; ") + std::string("named by the plymesh at ") + where.file + ":" +
                      std::to_string(where.line);
        return error;
    }

    SceneShape base;
    base.location = set.location;
    base.source_file = std::filesystem::path(*name).filename().string();
    base.positions = std::move(mesh->positions);
    base.normals = std::move(mesh->normals);
    base.uvs = std::move(mesh->uvs);
    const std::string shown = mesh_name(base);
    warn_repaired(repair_normals(base.normals, base.positions, mesh->triangles, mesh->quads), base, shown, warnings);
    take_context(base, context);
    std::size_t dropped = mesh->short_faces;
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
