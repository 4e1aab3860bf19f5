#include "transport/import/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "transport/import/mesh_shapes.h"

namespace raylex::transport {

namespace {

constexpr std::string_view supported[] = {"trianglemesh", "plymesh", "sphere", "disk", "cylinder", "bilinearmesh"};
constexpr std::string_view unsupported[] = {"curve",       "loopsubdiv", "cone",       "paraboloid",
                                            "hyperboloid", "nurbs",      "heightfield"};

/// Reads real parameters one after the other and keeps the first failure.
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

Result<std::vector<SceneShape>> make_quadric(ShapeKind kind, const ParameterSet& set, const ShapeContext& context) {
    SceneShape shape;
    shape.kind = kind;
    shape.location = set.location;
    shape.object_to_world = context.object_to_world;
    shape.flip_normal = context.reverse_orientation != context.object_to_world.swaps_handedness();
    RealReader real(set);
    shape.radius = real("radius", 1);
    real.require(shape.radius > 0, "radius is not above 0");
    shape.phi_max = std::clamp(real("phimax", 360), Real(0), Real(360));
    real.require(shape.phi_max > 0, "'phimax' leaves nothing; expected degrees above 0, at most 360");
    if (kind == ShapeKind::disk) {
        shape.height = real("height", 0);
        shape.inner_radius = real("innerradius", 0);
        real.require(shape.inner_radius >= 0 && shape.inner_radius < shape.radius,
                     "'innerradius' leaves nothing; expected 0 up to below the radius");
    } else {
        const bool sphere = kind == ShapeKind::sphere;
        const Real a = real("zmin", sphere ? -shape.radius : -1), b = real("zmax", sphere ? shape.radius : 1);
        const Real reach = sphere ? shape.radius : std::numeric_limits<Real>::infinity();
        shape.z_min = std::clamp(std::min(a, b), -reach, reach);
        shape.z_max = std::clamp(std::max(a, b), -reach, reach);
        real.require(shape.z_min < shape.z_max, "'zmin' and 'zmax' leave nothing of the shape");
    }
    if (!real.status()) return real.status().error();
    return std::vector<SceneShape>{std::move(shape)};
}

Error unknown_shape(const std::string& type, const SourceLocation& where) {
    std::string list;
    std::vector<std::string> names;
    for (const std::string_view name : supported) {
        list.append(list.empty() ? "" : ", ").append(name);
        names.emplace_back(name);
    }
    if (std::find(std::begin(unsupported), std::end(unsupported), type) != std::end(unsupported))
        return error_at(where, "shape '" + type + "' is not supported yet; supported are " + list);
    const std::string near = nearest_name(type, names);
    return error_at(where, "unknown shape '" + type + "'; expected one of " + list,
                    near.empty() ? "" : "did you mean '" + near + "'?");
}

/// `alpha`: a number or the name of a float texture, for every kind of shape.
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

Result<std::vector<SceneShape>> make_shapes(const std::string& type, const ParameterSet& set,
                                            const ShapeContext& context, std::vector<Error>& warnings) {
    Result<std::vector<SceneShape>> shapes = unknown_shape(type, set.location);
    if (type == "trianglemesh") shapes = make_triangle_mesh(set, context, warnings);
    else if (type == "plymesh") shapes = make_ply_mesh(set, context, warnings);
    else if (type == "bilinearmesh") shapes = make_bilinear_mesh(set, context, warnings);
    else if (type == "sphere") shapes = make_quadric(ShapeKind::sphere, set, context);
    else if (type == "disk") shapes = make_quadric(ShapeKind::disk, set, context);
    else if (type == "cylinder") shapes = make_quadric(ShapeKind::cylinder, set, context);
    if (!shapes) return shapes;
    if (Status status = read_alpha(set, *shapes); !status) return status.error();
    return shapes;
}

}  // namespace raylex::transport
