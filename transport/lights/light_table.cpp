#include "transport/lights/light_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "display/services/short_number.h"
#include "transport/lights/area_images.h"

namespace raylex::transport {

std::int32_t LightTable::group_index(const std::string& group) {
    const auto found = std::find(groups_.begin(), groups_.end(), group);
    if (found != groups_.end()) return static_cast<std::int32_t>(found - groups_.begin());
    groups_.push_back(group);
    return static_cast<std::int32_t>(groups_.size()) - 1;
}

namespace {

Light make_triangle(const ShapeGeometry& shape, std::uint32_t primitive) {
    Light light;
    light.kind = LightKind::triangle;
    const Triangle& triangle = shape.triangles[primitive];
    const auto& i = triangle.corners;
    const Vec3 p0 = shape.positions[i[0]], p1 = shape.positions[i[1]], p2 = shape.positions[i[2]];
    light.position = p0;
    light.edge1 = p1 - p0;
    light.edge2 = p2 - p0;
    light.area = static_cast<Real>(0.5 * length(cross(DVec3(light.edge1), DVec3(light.edge2))));
    Vec3 normal = triangle.normal;
    if (!shape.normals.empty()) {
        const Vec3 shading = shape.normals[i[0]] + shape.normals[i[1]] + shape.normals[i[2]];
        normal = face_forward(normal, shading);
    } else if (shape.flip_normal) {
        normal = -normal;
    }
    light.direction = normal;
    // A point on it is a sum of floats: five roundings of the summands.
    light.offset = triangle.offset;
    light.offset.here += gamma_bound(8) * dot(absolute(light.direction),
                                              absolute(light.position) + absolute(light.edge1) + absolute(light.edge2));
    return light;
}

/// Makes the light of a quadric. With an image, spheres too are sampled by area.
Light make_quadric(const ShapeGeometry& shape, bool has_image) {
    Light light;
    const Quadric& q = shape.quadric;
    double scale = 1;
    light.kind = LightKind::quadric;
    light.area = static_cast<Real>(q.object_area());
    if (!has_image && q.kind == ShapeKind::sphere && !q.partial && keeps_angles(q.placement.to_world, scale, 1e-9)) {
        light.kind = LightKind::sphere;
        light.position = q.placement.to_world.point({0, 0, 0}).to_real();
        light.area = static_cast<Real>(q.object_area() * scale * scale);
    }
    return light;
}

/// The error for an emission whose factors are in range but whose product is not.
Error beyond_float(const SceneEntity& light) {
    return error_at(light.location, "the emission of this " + light.type +
                                        " light, its colour times 'scale', is beyond the range of float; expected less "
                                        "than 3.4e38");
}

/// The world area of a light's primitive, for its power.
double world_area(const ShapeGeometry& shape, const Light& light) {
    if (light.kind != LightKind::quadric) return light.area;
    double sum = 0;  // the stretch varies over the surface: 8 x 8 points uniform by object-space area
    for (int j = 0; j < 8; ++j)
        for (int i = 0; i < 8; ++i) {
            double u, v;
            shape.quadric.sample_area((i + 0.5) / 8, (j + 0.5) / 8, u, v);
            sum += shape.quadric.world_point(u, v).area_scale;
        }
    return light.area * sum / 64;
}

}  // namespace

Status LightTable::add_area_lights(const SceneDescription& scene, EmbreeScene& geometry, LightContext& context,
                                   std::vector<Error>& warnings) {
    std::vector<AreaEmission> emissions;
    for (const SceneAreaLight& area : scene.area_lights) {
        auto entry = area_light_registry().require(area.type, area.location);
        if (!entry) return entry.error();
        auto emission = (*entry)->factory(area, context);
        if (!emission) return emission.error();
        if (!is_finite(emission->radiance)) return beyond_float(area);
        emissions.push_back(*emission);
    }
    for (const SceneObject& object : scene.objects)
        for (const SceneShape& shape : object.shapes)
            if (shape.area_light >= 0)
                warnings.push_back(
                    error_at(shape.location, "area lights in an object instance are ignored, as pbrt does"));
    for (std::uint32_t s = 0; s < geometry.top_level_shapes(); ++s) {
        ShapeGeometry& shape = geometry.shapes()[s];
        if (shape.area_light < 0) continue;
        if (static_cast<std::size_t>(shape.area_light) >= emissions.size())
            return error_at(scene.shapes[s].location, "the shape's area light is not defined");
        if (shape.kind == ShapeKind::curves)
            return error_at(scene.shapes[s].location,
                            "curves with an area light are not supported; expected a mesh or a quadric under an "
                            "AreaLightSource (pbrt-v4 does not sample light on curves either)");
        const AreaEmission& emission = emissions[static_cast<std::size_t>(shape.area_light)];
        const std::int32_t group = group_index(scene.area_lights[static_cast<std::size_t>(shape.area_light)].group);
        shape.first_light = static_cast<std::uint32_t>(lights_.size());
        if (emission.power > 0 && shape.primitive_count > 1)
            warnings.push_back(error_at(scene.area_lights[static_cast<std::size_t>(shape.area_light)].location,
                                        "'power' is that of each of the mesh's " +
                                            std::to_string(shape.primitive_count) +
                                            " primitives, as in pbrt-v4; the mesh emits that many times as much"));
        for (std::uint32_t i = 0; i < shape.primitive_count; ++i) {
            Light light;
            if (shape.kind == ShapeKind::triangle_mesh) {
                light = make_triangle(shape, i);
            } else if (shape.kind == ShapeKind::bilinear_mesh) {
                light.kind = LightKind::patch;
                light.area = static_cast<Real>(shape.patch(i).area());
            } else {
                light = make_quadric(shape, emission.image >= 0);
            }
            light.hidden = shape.hidden;
            light.group = group;
            light.shape = s;
            light.primitive = i;
            set_emission(emission, shape, light);
            lights_.push_back(light);
        }
    }
    return success();
}

/// Sets the emission of the primitive, and the weight of its selection.
void LightTable::set_emission(const AreaEmission& emission, const ShapeGeometry& shape, Light& light) {
    light.emission = emission.radiance;
    light.two_sided = emission.two_sided;
    const double sides = light.two_sided ? 2 : 1, area = world_area(shape, light);
    double mean = 1;
    if (emission.image >= 0) {
        const EmissionImage& shown = images_.emissions[static_cast<std::size_t>(emission.image)];
        light.image = static_cast<std::int32_t>(images_.points.size());
        PrimitiveImage part = image_on_primitive(light, shape, shown);
        images_.points.push_back({emission.image, std::move(part.points)});
        mean = part.mean_luminance;
    }
    if (emission.power > 0) {
        const double whole = emission.image >= 0 ? images_.emissions[static_cast<std::size_t>(emission.image)].mean : 1,
                     given = static_cast<double>(pi) * area * sides * whole;
        light.emission = given > 0 ? light.emission * static_cast<Real>(emission.power / given) : Rgb();
    }
    light.power = double{luminance(light.emission)} * pi * area * sides * mean;
    // Repeats the look-up for an image whose samples found none of its light.
    if (!(mean > 0) && images_.emissions[static_cast<std::size_t>(emission.image)].mean > 0)
        light.power = light.emission.max();
}

void LightTable::finish(const EmbreeScene& geometry) {
    const double radius = std::max(geometry.lit_bounds().radius(), Real(1e-30));
    for (std::uint32_t i = 0; i < lights_.size(); ++i) {
        Light& light = lights_[i];
        if (light.kind == LightKind::distant) light.power = double{luminance(light.emission)} * pi * radius * radius;
        if (light.is_environment()) {
            environment_lights_.push_back(i);
            const double mean = light.kind == LightKind::image_environment ? environment_of(light).mean_luminance() : 1;
            light.power = double{luminance(light.emission)} * mean * 4 * pi * pi * radius * radius;
            if (light.kind == LightKind::portal_environment)
                light.power = double{luminance(light.emission)} * portal_of(light).flux();
        }
        if (!(light.power >= 0)) light.power = light.emission.max();  // a colour of negative luminance
        if (light.is_area() && !(light.area > 0)) light.power = 0;
        light.power = std::min(light.power, 1e300);  // weights and their sum must be finite
        any_to_hit_ = any_to_hit_ || (light.power > 0 && !light.is_delta());
    }
    for (std::size_t i = 0; i < light_choices; ++i) choosers_[i] = LightChooser(lights_, static_cast<LightChoice>(i));
}

Result<LightTable> LightTable::build(const SceneDescription& scene, EmbreeScene& geometry,
                                     std::vector<Error>& warnings) {
    LightTable table;
    LightContext context{scene, table.images_, warnings, geometry.space()};
    if (Status s = table.add_area_lights(scene, geometry, context, warnings); !s) return s.error();
    for (const SceneLight& given : scene.lights) {
        SceneLight source = given;
        auto entry = light_registry().require(source.type, source.location);
        if (!entry) return entry.error();
        source.to_world = geometry.space().placed(given.to_world);
        if (const Matrix4& matrix = given.to_world.matrix();
            (source.type == "infinite" || source.type == "distant") && matrix[3] != std::array<double, 4>{0, 0, 0, 1}) {
            // Directions have no position. pbrt-v4 uses different parts of such a matrix and of its inverse.
            source.to_world = Matrix34(matrix).transform();
            if (!source.to_world.invertible())
                return error_at(source.location, "the linear part of the " + source.type +
                                                     " light's matrix cannot be inverted; expected an invertible one");
            warnings.push_back(error_at(source.location,
                                        "the last row of the " + source.type +
                                            " light's matrix is not 0 0 0 1; only its effect on directions is used",
                                        "Transform and ConcatTransform take matrices column by column"));
        }
        auto light = (*entry)->factory(source, context);
        if (!light) return light.error();
        // look-ups marked the copy's parameters as used
        for (std::size_t i = 0; i < given.parameters.parameters.size(); ++i)
            given.parameters.parameters[i].used |= source.parameters.parameters[i].used;
        if (light->is_at_point()) {
            const Vec3& at = light->position;
            if (!(std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) <= largest_coordinate))
                return error_at(source.location,
                                "the light stands at (" + short_number(at.x, 6) + ", " + short_number(at.y, 6) + ", " +
                                    short_number(at.z, 6) + "); expected no coordinate beyond 1e18",
                                "another unit of length brings it into range");
        }
        if (!is_finite(light->emission)) return beyond_float(source);
        light->group = table.group_index(source.group);
        table.lights_.push_back(*light);
    }
    table.finish(geometry);
    return table;
}

}  // namespace raylex::transport
