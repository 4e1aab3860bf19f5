#include "transport/embree/scene_limits.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "display/services/short_number.h"

namespace raylex::transport {
namespace {

bool finite(const StoredVec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Error too_far(const SceneShape& shape, double distance) {
    return error_at(shape.location,
                    "the shape reaches to " + short_number(distance) + " from the origin; expected at most " +
                        short_number(double{largest_coordinate}) + ", beyond which squares of lengths overflow float",
                    "another unit of length brings it into range");
}

double largest_of(const BasicVec3<double>& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Embree inverts the matrix of an instance in single precision by its adjoint and determinant: both must be in the
/// range of float. Returns an empty string if they are, else a description of the value.
std::string not_invertible_as_float(const Matrix34& matrix) {
    Matrix34 rounded;  // as Embree receives it
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 4; ++c) rounded.m[r][c] = static_cast<double>(static_cast<float>(matrix.m[r][c]));
    const auto& m = rounded.m;
    double largest_minor = 0, products = 0;  // the six products of the determinant, without their signs
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            const double minor = std::abs(m[r1][c1] * m[r2][c2]) + std::abs(m[r1][c2] * m[r2][c1]);
            largest_minor = std::max(largest_minor, minor);
            if (r == 0) products += std::abs(m[r][c]) * minor;
        }
    const double determinant = std::abs(rounded.determinant());
    if (!(largest_minor < 1e36 && determinant > 1e-30 && determinant < 1e30))
        return "its determinant is " + short_number(matrix.determinant()) + "; expected 1e-30 to 1e30";
    // Five roundings of 2^-24 separate these products from their sum in float. A sum four times as large keeps three
    // quarters of it, and the inverse is at most a third too large.
    constexpr double least = 20.0 / (1 << 24);
    if (!(determinant > least * products))
        return "its determinant is " + short_number(determinant) + ", a sum of products as large as " +
               short_number(products) + "; expected at least " + short_number(least) + " of that";
    return {};
}

double reach_of(const Matrix34& to_world, const Bounds& b) {
    double reach = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p{corner & 1 ? b.upper.x : b.lower.x, corner & 2 ? b.upper.y : b.lower.y,
                     corner & 4 ? b.upper.z : b.lower.z};
        const DVec3 placed = to_world.point(DVec3(p));
        reach = std::max({reach, std::abs(placed.x), std::abs(placed.y), std::abs(placed.z)});
    }
    return reach;
}

}  // namespace

double ShapeGeometry::extent() const {
    if (kind == ShapeKind::curves) return curves.extent;
    if (kind != ShapeKind::triangle_mesh && kind != ShapeKind::bilinear_mesh) return quadric.extent();
    double extent = 0;
    for (const StoredVec3& position : patch_positions) extent = std::max(extent, largest_of(position));
    for (const Triangle& triangle : triangles)
        for (const std::uint32_t corner : triangle.corners) extent = std::max(extent, largest_of(positions[corner]));
    return extent;
}

double ShapeGeometry::reach_of_rays() const {
    double edge = kind == ShapeKind::curves ? curves.extent : 0;
    for (const Triangle& triangle : triangles) {
        const auto& [a, b, c] = triangle.corners;
        for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
            edge = std::max(edge, largest_of(positions[from] - positions[to]));
    }
    // The sums of 12 products of the edges and of 3 with the distance between two points stay below 3.4e38.
    constexpr double most_product = 4e36;
    return std::min(double{largest_coordinate}, most_product / (edge * edge));
}

Status check_mesh(const SceneShape& shape, std::size_t per_primitive) {
    for (std::size_t i = 0; i < shape.positions.size(); ++i)
        if (!finite(shape.positions[i]))
            return error_at(shape.location,
                            "vertex " + std::to_string(i) + " of the mesh is not finite; expected real numbers");
    for (const std::uint32_t index : shape.indices)
        if (index >= shape.positions.size())
            return error_at(shape.location, "vertex index " + std::to_string(index) +
                                                " is out of range; the mesh has " +
                                                std::to_string(shape.positions.size()) + " vertices");
    if (shape.indices.size() % per_primitive != 0)
        return error_at(shape.location, "the number of indices is " + std::to_string(shape.indices.size()) +
                                            "; expected a multiple of " + std::to_string(per_primitive));
    if (!shape.normals.empty() && shape.normals.size() != shape.positions.size())
        return error_at(shape.location, std::to_string(shape.normals.size()) + " normals for " +
                                            std::to_string(shape.positions.size()) +
                                            " vertices; expected one each or none");
    if (!shape.uvs.empty() && shape.uvs.size() != shape.positions.size())
        return error_at(shape.location, std::to_string(shape.uvs.size()) + " uv pairs for " +
                                            std::to_string(shape.positions.size()) +
                                            " vertices; expected one each or none");
    return success();
}

Status check_quadric(const SceneShape& shape) {
    if (!shape.object_to_world.invertible()) return error_at(shape.location, "the shape's transform has no inverse");
    for (const Real v : {shape.radius, shape.z_min, shape.z_max, shape.phi_max, shape.height, shape.inner_radius})
        if (std::isnan(v)) return error_at(shape.location, "a parameter of the shape is not a number");
    if (!(shape.radius > 0) || !std::isfinite(shape.radius))
        return error_at(shape.location,
                        "the shape's radius is " + short_number(shape.radius, 6) + "; expected a positive number");
    return success();
}

Status check_extent(const SceneShape& shape, double extent) {
    if (extent <= double{largest_coordinate}) return success();
    return too_far(shape, extent);
}

Status check_extent(const SceneShape& shape, const std::vector<StoredVec3>& positions) {
    for (const StoredVec3& position : positions)
        if (!(largest_of(position) <= double{largest_coordinate})) return too_far(shape, largest_of(position));
    return success();
}

Status check_coincident(const SceneDescription& scene) {
    constexpr std::size_t most = 1000;
    if (scene.instances.size() <= most) return success();
    std::map<std::tuple<int, Matrix4, Matrix4>, std::size_t> known;
    for (const SceneInstance& each : scene.instances) {
        const Transform& end = each.motion < 0 ? each.to_world : scene.moved_to[static_cast<std::size_t>(each.motion)];
        if (++known[{each.object, each.to_world.matrix(), end.matrix()}] > most)
            return error_at(each.location,
                            "more than " + std::to_string(most) +
                                " instances of one object stand at the same place; expected one instance at a place");
    }
    return success();
}

double extent_without_shapes(const SceneDescription& scene, const RenderSpace& space) {
    double extent = 0;
    const auto take =
        [&](const BasicVec3<double>& place) {  // objects beyond all reach are an error of the camera or light
            if (const double distance = largest_of(place); distance <= double{largest_coordinate})
                extent = std::max(extent, distance);
        };
    take(space.placed(scene.camera_to_world).point({0, 0, 0}));
    for (const SceneLight& light : scene.lights) {
        const Parameter* from = light.type == "point" || light.type == "spot" ? light.parameters.find("from") : nullptr;
        const bool moved = from != nullptr && from->numbers.size() == 3;
        const auto at = [&](std::size_t i) { return moved ? from->numbers[i] : 0.0; };
        take(space.placed(light.to_world).point_in_double({at(0), at(1), at(2)}));
    }
    return extent;
}

namespace {

/// Light from infinity begins at three extents of the scene, and a shadow ray is two extents long.
constexpr double extents_of_rays = 4;

/// The distance from the world's origin within which rays may begin, so that in the instance's object they begin at
/// most `in_object` from its origin. Rays of the scene begin up to `rays` from the origin.
Result<Real> limit_in_world(const SceneInstance& instance, const Transform& to_world, double rays, double in_object) {
    const Placement placement(to_world);
    if (const std::string what = not_invertible_as_float(placement.to_world); !what.empty())
        return error_at(instance.location, "the instance's transform cannot be inverted in single precision: " + what,
                        "transforms of shapes have no such bound: place the shapes without an instance");
    double stretch = 0, shift = 0;
    for (const auto& row : placement.to_object.m) {
        stretch = std::max(stretch, std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
        shift = std::max(shift, std::abs(row[3]));
    }
    if (const double reach = rays * stretch + shift; !(reach <= in_object))
        return error_at(instance.location,
                        "in the space of the instance's object the scene reaches to " + short_number(reach) +
                            "; expected at most " + short_number(in_object),
                        "a less extreme transform brings it into range");
    return static_cast<Real>((in_object - shift) / stretch);
}

/// Checks that rays begin where floats can hold them. Errors name the object that is farthest out, whichever shape the
/// rays are traced to.
Status check_rays(const SceneDescription& scene, const PlacedShapes& placed, double rays,
                  const SceneInstance* farthest_instance) {
    if (rays <= double{largest_coordinate}) return success();
    const double extent = rays / extents_of_rays;
    const std::string most = short_number(double{largest_coordinate} / extents_of_rays);
    const auto reaches = [&](const SourceLocation& where, const char* what) {
        return error_at(where,
                        std::string("the ") + what + " reaches to " + short_number(extent) +
                            " from the origin; expected at most " + most +
                            ", as light from infinity begins at several times that distance",
                        "another unit of length brings it into range");
    };
    if (farthest_instance != nullptr) return reaches(farthest_instance->location, "instance");
    for (std::size_t i = 0; i < scene.shapes.size(); ++i)
        if (placed.shapes[i].extent() >= extent) return reaches(scene.shapes[i].location, "shape");
    return error_at(scene.camera.location,
                    "the camera or a light stands " + short_number(extent) + " from the origin; expected at most " +
                        most + ", as light from infinity begins at several times that distance",
                    "another unit of length brings it into range");
}

}  // namespace

Result<Real> limit_of_rays(const SceneDescription& scene, const PlacedShapes& placed, double extent) {
    const double most = double{largest_coordinate};
    Real limit = largest_coordinate;
    const SceneInstance* farthest_instance = nullptr;  // set if no shape, camera or light is as far
    const auto usable = [&](const SceneInstance& instance) {
        return instance.object >= 0 && static_cast<std::size_t>(instance.object) < scene.objects.size() &&
               instance.to_world.invertible();
    };
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const SceneInstance& instance = scene.instances[i];
        if (!usable(instance)) continue;  // another check reports it
        const std::optional<Bounds>& bounds = placed.object_bounds[static_cast<std::size_t>(instance.object)];
        if (!bounds) continue;
        for (std::size_t step = 0; step < placed.instances.steps(i); ++step) {
            const double reach = reach_of(Matrix34(placed.instances.at(i, step).matrix()), *bounds);
            if (!(reach <= most))
                return error_at(instance.location, "the instance reaches to " + short_number(reach) +
                                                       " from the origin; expected at most " + short_number(most));
            if (reach > extent) farthest_instance = &instance;
            extent = std::max(extent, reach);
        }
    }
    const double rays = extents_of_rays * extent;
    if (!scene.shapes.empty() || !scene.instances.empty())
        if (Status s = check_rays(scene, placed, rays, farthest_instance); !s) return s.error();
    for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
        const double reach = placed.shapes[i].reach_of_rays();
        if (!(rays <= reach))
            return error_at(scene.shapes[i].location,
                            "rays of the scene begin as far as " + short_number(rays) +
                                " from the origin, and this shape can be "
                                "traced from " +
                                short_number(reach) + " at most, in single precision",
                            "another unit of length, or smaller triangles, bring it into range");
        limit = std::min(limit, static_cast<Real>(reach));
    }
    std::vector<double> reaches;  // [object]
    for (std::size_t k = 0, shape = scene.shapes.size(); k < scene.objects.size(); ++k) {
        double least = most;
        for (std::size_t i = 0; i < scene.objects[k].shapes.size(); ++i, ++shape)
            least = std::min(least, placed.shapes[shape].reach_of_rays());
        reaches.push_back(least);
    }
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const SceneInstance& instance = scene.instances[i];
        if (!usable(instance)) continue;
        for (std::size_t step = 0; step < placed.instances.steps(i); ++step) {
            auto reach = limit_in_world(instance, placed.instances.at(i, step), rays,
                                        reaches[static_cast<std::size_t>(instance.object)]);
            if (!reach) return reach.error();
            limit = std::min(limit, *reach);
        }
    }
    return limit;
}

}  // namespace raylex::transport
