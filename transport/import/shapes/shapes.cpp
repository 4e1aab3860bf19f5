#include "transport/import/shapes/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "transport/import/shapes/curve_shapes.h"
#include "transport/import/shapes/loop_subdivision.h"
#include "transport/import/shapes/mesh_shapes.h"

namespace raylex::transport {

namespace {

constexpr std::string_view unsupported[] = {"cone", "paraboloid", "hyperboloid", "nurbs", "heightfield"};

/// Reads real parameters one after the other and keeps the first error.
class RealReader {
  public:
    explicit RealReader(const ParameterSet& set) : set_(set) {}

    Real operator()(std::string_view name, double fallback) {
        const Result<double> value = set_.real_or(name, fallback);
        if (!value) return fail(value.error());
        if (!std::isfinite(static_cast<float>(*value)))
            return fail(error_at(set_.location, std::string(name).append(" is beyond the range of float")));
        return static_cast<Real>(*value);
    }
    void require(bool holds, const std::string& message) {
        if (!holds) fail(error_at(set_.location, message));
    }
    [[nodiscard]] const Status& status() const { return status_; }

  private:
    Real fail(Error error) {
        if (status_) status_ = std::move(error);
        return 0;
    }

    const ParameterSet& set_;
    Status status_ = success();
};

Result<std::vector<SceneShape>> make_quadric(ShapeKind kind, const ParameterSet& set, const ShapeContext& context,
                                             std::vector<Error>& warnings) {
    SceneShape shape;
    shape.kind = kind;
    shape.location = set.location;
    shape.object_to_world = context.object_to_world;
    shape.flip_normal = context.reverse_orientation != context.object_to_world.swaps_handedness();
    RealReader real(set);
    shape.radius = real("radius", 1);
    // pbrt-v4 keeps such shapes, but no ray hits them.
    const auto left_out = [&](const std::string& why) {
        warnings.push_back(error_at(set.location, why + ": the shape has no area and is left out"));
        return std::vector<SceneShape>();
    };
    if (real.status() && shape.radius == 0) return left_out("radius is 0; expected a length above 0");
    real.require(shape.radius > 0, "radius is not above 0");
    shape.phi_max = std::clamp(real("phimax", 360), Real(0), Real(360));
    if (real.status() && shape.phi_max == 0)
        return left_out("'phimax' leaves no surface; expected degrees above 0, at most 360");
    if (kind == ShapeKind::disk) {
        shape.height = real("height", 0);
        shape.inner_radius = real("innerradius", 0);
        real.require(shape.inner_radius >= 0, "'innerradius' is below 0");
        if (real.status() && shape.inner_radius >= shape.radius)
            return left_out("'innerradius' leaves no surface; expected at least 0 and less than the radius");
    } else {
        const bool sphere = kind == ShapeKind::sphere;
        const Real a = real("zmin", sphere ? -shape.radius : -1), b = real("zmax", sphere ? shape.radius : 1);
        const Real reach = sphere ? shape.radius : std::numeric_limits<Real>::infinity();
        shape.z_min = std::clamp(std::min(a, b), -reach, reach);
        shape.z_max = std::clamp(std::max(a, b), -reach, reach);
        real.require(shape.z_min < shape.z_max, "'zmin' and 'zmax' leave no surface");
    }
    if (!real.status()) return real.status().error();
    return std::vector<SceneShape>{std::move(shape)};
}

/// The registry's entry, or an Error that lists the types that raylex supports.
Result<const Registry<ShapeFactory>::Entry*> find_shape(const std::string& type, const SourceLocation& where) {
    if (shape_registry().find(type) != nullptr ||
        std::find(std::begin(unsupported), std::end(unsupported), type) == std::end(unsupported))
        return shape_registry().require(type, where);
    std::string list;
    for (const std::string& name : shape_registry().names()) list.append(list.empty() ? "" : ", ").append(name);
    return error_at(where, "shape '" + type + "' is not supported yet; supported are " + list);
}

/// Reads `alpha` of any shape: a number or the name of a float texture.
Status read_alpha(const ParameterSet& set, std::vector<SceneShape>& shapes) {
    const Parameter* alpha = set.find("alpha");
    if (alpha == nullptr) return success();
    const bool texture = alpha->type == ParameterType::texture && alpha->strings.size() == 1;
    const bool number = alpha->type == ParameterType::real && alpha->numbers.size() == 1;
    if (!texture && !number)
        return error_at(alpha->location,
                        "'alpha' has the wrong type; expected one \"float alpha\" or \"texture alpha\"");
    for (SceneShape& shape : shapes) {
        if (texture) shape.alpha_texture = alpha->strings.front();
        else shape.alpha = static_cast<Real>(std::clamp(alpha->numbers.front(), 0.0, 1.0));
    }
    return success();
}

}  // namespace

Registry<ShapeFactory>& shape_registry() {
    static Registry<ShapeFactory> registry = [] {
        using T = ParameterType;
        Registry<ShapeFactory> r("shape");
        const ParameterDescription points{"P", T::point3, "", "vertices"},
            normals{"N", T::normal, "", "shading normals, one a vertex"},
            uvs{"uv", T::point2, "", "texture coordinates, one a vertex"}, radius{"radius", T::real, "1", "above 0"},
            phi_max{"phimax", T::real, "360", "degrees around z"};
        const auto indices = [](const char* help) { return ParameterDescription{"indices", T::integer, "", help}; };
        const auto quadric = [](ShapeKind kind) {
            return [kind](const ParameterSet& set, const ShapeContext& context, std::vector<Error>& warnings) {
                return make_quadric(kind, set, context, warnings);
            };
        };
        r.add({"trianglemesh", "triangles", {points, normals, uvs, indices("three a triangle")}, make_triangle_mesh});
        r.add({"bilinearmesh",
               "bilinear patches",
               {points, normals, uvs, indices("four a patch: p00 p10 p01 p11")},
               make_bilinear_mesh});
        r.add({"plymesh",
               "triangles and quadrilaterals of a PLY file",
               {{"filename", T::string, "", "beside the scene file, or absolute"},
                {"displacement", T::texture, "", "along normals; a float texture"},
                {"edgelength", T::real, "1", "longest edge of a displaced mesh, in the world: longer edges are halved"},
                {"displacement.edgelength", T::real, "1", "the same"}},
               make_ply_mesh});
        r.add({"sphere",
               "a sphere around the origin",
               {radius, {"zmin", T::real, "-radius", "cut below"}, {"zmax", T::real, "radius", "cut above"}, phi_max},
               quadric(ShapeKind::sphere)});
        r.add({"disk",
               "across z",
               {radius, {"height", T::real, "0", "its z"}, {"innerradius", T::real, "0", "of the hole"}, phi_max},
               quadric(ShapeKind::disk)});
        r.add({"cylinder",
               "around z, open",
               {radius, {"zmin", T::real, "-1", "lower end"}, {"zmax", T::real, "1", "upper end"}, phi_max},
               quadric(ShapeKind::cylinder)});
        r.add({"curve",
               "Bezier or B-spline curves with a width",
               {{"type", T::string, "flat", "flat (faces every ray), cylinder (round) or ribbon (oriented by N)"},
                {"basis", T::string, "bezier", "bezier or bspline"},
                {"degree", T::integer, "3", "2 or 3"},
                {"P", T::point3, "", "control points"},
                {"N", T::normal, "", "ribbons: one at each end of every segment"},
                {"width", T::real, "1", "across"},
                {"width0", T::real, "width", "at the start"},
                {"width1", T::real, "width", "at the end"}},
               make_curve});
        r.add({"loopsubdiv",
               "Loop's subdivision surface, as the triangles of its limit",
               {{"levels", T::integer, "3", "each splits a triangle into four"},
                points,
                indices("three a face"),
                {"scheme", T::string, "loop", "loop"}},
               make_loop_subdivision});
        return r;
    }();
    return registry;
}

Result<std::vector<SceneShape>> make_shapes(const std::string& type, const ParameterSet& set,
                                            const ShapeContext& context, std::vector<Error>& warnings) {
    const auto entry = find_shape(type, set.location);
    if (!entry) return entry.error();
    Result<std::vector<SceneShape>> shapes = (*entry)->factory(set, context, warnings);
    if (!shapes) return shapes;
    if (Status status = read_alpha(set, *shapes); !status) return status.error();
    return shapes;
}

}  // namespace raylex::transport
