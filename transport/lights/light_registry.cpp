// Makes lights from pbrt-v4's LightSource and AreaLightSource directives, with pbrt's parameters and defaults.
#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "display/services/short_number.h"
#include "transport/color/spectrum.h"
#include "transport/lights/light_factories.h"

namespace raylex::transport {
namespace {

std::string quoted(std::string_view name) {
    return std::string("'").append(name).append("'");
}

/// Points stay in double until they are in the space of light transport.
using Point = BasicVec3<double>;

Result<Point> point_or(const ParameterSet& set, std::string_view name, const Point& fallback) {
    const Parameter* p = set.find(name);
    if (!p) return fallback;
    if (p->type != ParameterType::point3 || p->numbers.size() != 3)
        return error_at(p->location, quoted(name).append(" must be one point3"));
    return Point{p->numbers[0], p->numbers[1], p->numbers[2]};
}

Vec3 placed(const Transform& transform, const Point& p) {
    return DVec3(transform.point_in_double(p)).to_real();
}

Vec3 direction_in_world(const Transform& transform, const Point& from, const Point& to) {
    const DVec3 v = normalize(DVec3(to) - DVec3(from));
    return normalize(Matrix34(transform.matrix()).vector(v)).to_real();
}

Result<Light> make_point(const SceneLight& source, LightContext& context) {
    Light light;
    light.kind = LightKind::point;
    auto intensity = scaled_emission(source, "I", context);
    if (!intensity) return intensity.error();
    auto power = source.parameters.real_or("power", -1);
    if (!power) return power.error();
    auto from = point_or(source.parameters, "from", {});
    if (!from) return from.error();
    light.emission = *power > 0 ? *intensity * static_cast<Real>(*power / (4 * static_cast<double>(pi))) : *intensity;
    light.position = placed(source.to_world, *from);
    light.power = 4 * pi * luminance(light.emission);
    return light;
}

Result<Light> make_spot(const SceneLight& source, LightContext& context) {
    Light light;
    light.kind = LightKind::spot;
    auto intensity = scaled_emission(source, "I", context);
    if (!intensity) return intensity.error();
    auto power = source.parameters.real_or("power", -1);
    auto cone = source.parameters.real_or("coneangle", 30), delta = source.parameters.real_or("conedeltaangle", 5);
    for (const auto* each : {&power, &cone, &delta})
        if (!*each) return each->error();
    auto from = point_or(source.parameters, "from", {}), to = point_or(source.parameters, "to", {0, 0, 1});
    if (!from) return from.error();
    if (!to) return to.error();
    if (*from == *to)
        return error_at(source.location, "spot light: 'from' and 'to' are the same point; expected a direction");
    const double degree = static_cast<double>(pi) / 180;
    const auto versine = [](double angle) {
        const double half = elementary::sin(0.5 * angle);
        return static_cast<Real>(2 * half * half);
    };
    light.versine_zero = versine(*cone * degree);
    light.versine_full = versine((*cone - *delta) * degree);
    if (!(light.versine_full < light.versine_zero))
        light.versine_full = light.versine_zero * (1 - 2 * unit_roundoff);  // a hard edge
    light.position = placed(source.to_world, *from);
    light.direction = direction_in_world(source.to_world, *from, *to);
    // Exporters print matrices with six digits, so a cone is only that round.
    if (double scale; !keeps_angles(Matrix34(source.to_world.matrix()), scale, 1e-5)) {
        light.image = static_cast<std::int32_t>(context.images.spots.size());
        context.images.spots.emplace_back(normalize(DVec3(*to) - DVec3(*from)), light.versine_full, light.versine_zero,
                                          Placement(source.to_world));
    }
    // pbrt's k_e for "power": full inside the falloff, half of it on average within the falloff.
    const Real solid_angle = pi * (light.versine_full + light.versine_zero);
    light.emission = *power > 0 ? *intensity * (static_cast<Real>(*power) / solid_angle) : *intensity;
    light.power = solid_angle * luminance(light.emission);
    return light;
}

Result<Light> make_distant(const SceneLight& source, LightContext& context) {
    Light light;
    light.kind = LightKind::distant;
    auto radiance = scaled_emission(source, "L", context);
    if (!radiance) return radiance.error();
    auto illuminance = source.parameters.real_or("illuminance", -1);
    if (!illuminance) return illuminance.error();
    auto from = point_or(source.parameters, "from", {}), to = point_or(source.parameters, "to", {0, 0, 1});
    if (!from) return from.error();
    if (!to) return to.error();
    if (*from == *to)
        return error_at(source.location, "distant light: 'from' and 'to' are the same point; expected a direction");
    light.emission = *illuminance > 0 ? *radiance * static_cast<Real>(*illuminance) : *radiance;
    light.direction = direction_in_world(source.to_world, *to, *from);
    return light;
}

const ParameterDescription scale_parameter{"scale", ParameterType::real, "1", "factor on the emission"};

Registry<LightFactory> make_lights() {
    using T = ParameterType;
    Registry<LightFactory> registry("light source");
    registry.add({"point",
                  "a point light that emits equally in all directions",
                  {{"I", T::rgb, "1 1 1", "radiant intensity"},
                   scale_parameter,
                   {"power", T::real, "", "total power; replaces that of I"},
                   {"from", T::point3, "0 0 0", "position"}},
                  make_point});
    registry.add({"spot",
                  "a point light that emits into a cone",
                  {{"I", T::rgb, "1 1 1", "radiant intensity on the axis"},
                   scale_parameter,
                   {"power", T::real, "", "total power; replaces that of I"},
                   {"from", T::point3, "0 0 0", "position"},
                   {"to", T::point3, "0 0 1", "a point on the axis"},
                   {"coneangle", T::real, "30", "degrees from the axis at which light ends"},
                   {"conedeltaangle", T::real, "5", "degrees over which it falls off inside that"}},
                  make_spot});
    registry.add({"distant",
                  "parallel light",
                  {{"L", T::rgb, "1 1 1", "irradiance on a surface facing it"},
                   scale_parameter,
                   {"illuminance", T::real, "", "factor on L"},
                   {"from", T::point3, "0 0 0", "light flows from here"},
                   {"to", T::point3, "0 0 1", "to here"}},
                  make_distant});
    registry.add({"infinite",
                  "radiance from all around: uniform, or a square equal-area octahedral image",
                  {{"L", T::rgb, "1 1 1", "radiance"},
                   scale_parameter,
                   {"filename", T::string, "", "image instead of L"},
                   {"illuminance", T::real, "", "illuminance of a surface that faces the light's own +z"},
                   {"portal", T::point3, "",
                    "corners of a rectangle in the world, through which alone light comes; facing out by (p3 - p0) x "
                    "(p1 - p0)"}},
                  make_infinite});
    registry.add({"goniometric",
                  "a point light with an image over directions, square and equal-area octahedral",
                  {{"I", T::rgb, "1 1 1", "radiant intensity where the image is 1"},
                   scale_parameter,
                   {"power", T::real, "", "total power; replaces that of I"},
                   {"filename", T::string, "", "the image; colours count as their mean"}},
                  make_goniometric});
    registry.add({"projection",
                  "a point light that projects an image along +z",
                  {scale_parameter,
                   {"power", T::real, "", "total power; replaces that of the image"},
                   {"fov", T::real, "90", "degrees that the image's shorter side spans"},
                   {"filename", T::string, "", "the image: radiant intensity"}},
                  make_projection});
    return registry;
}

}  // namespace

Result<Rgb> scaled_emission(const SceneEntity& light, std::string_view name, const LightContext& context) {
    auto emission = spectrum_or(light.parameters, name, recorded_light(Rgb(1), context.scene.color),
                                SpectrumRole::illuminant, context.scene.color);
    if (!emission) return emission;
    auto scale = light_scale(light);
    if (!scale) return scale.error();
    return *emission * static_cast<Real>(*scale);
}

Result<double> light_scale(const SceneEntity& light) {
    auto scale = light.parameters.real_or("scale", 1);
    if (scale && *scale < 0)
        return error_at(light.parameters.find("scale")->location,
                        "'scale' is " + short_number(*scale, 6) + "; expected 0 or more");
    return scale;
}

Registry<LightFactory>& light_registry() {
    static Registry<LightFactory> registry = make_lights();
    return registry;
}

Registry<AreaLightFactory>& area_light_registry() {
    static Registry<AreaLightFactory> registry = [] {
        Registry<AreaLightFactory> r("area light source");
        r.add({"diffuse",
               "the same radiance in all directions of the normal's side",
               {{"L", ParameterType::rgb, "1 1 1", "radiance"},
                scale_parameter,
                {"filename", ParameterType::string, "", "image of radiance, by texture coordinates, instead of L"},
                {"power", ParameterType::real, "", "power of each primitive; replaces that of the radiance"},
                {"twosided", ParameterType::boolean, "false", "both sides emit"}},
               make_diffuse_area});
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
