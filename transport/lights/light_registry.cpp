// What pbrt-v4's LightSource and AreaLightSource directives mean. Parameters and defaults are pbrt's.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "transport/color/spectrum.h"
#include "transport/import/image.h"
#include "transport/lights/light_table.h"

namespace raylex::transport {
namespace {

std::string quoted(std::string_view name) {
    return std::string("'").append(name).append("'");
}

/// Points stay in double until they stand where light transport computes.
using Point = BasicVec3<double>;

Result<Point> point_or(const ParameterSet& set, std::string_view name, const Point& fallback) {
    const Parameter* p = set.find(name);
    if (!p) return fallback;
    if (p->type != ParameterType::point3 || p->numbers.size() != 3)
        return error_at(p->location, quoted(name).append(" must be one point3"));
    return Point{p->numbers[0], p->numbers[1], p->numbers[2]};
}

Status refuse(const ParameterSet& set, std::string_view name, const std::string& why) {
    if (const Parameter* p = set.find(name)) return error_at(p->location, quoted(name).append(" ").append(why));
    return success();
}

/// The colour parameter `name` times "scale".
Result<Rgb> scaled_emission(const SceneEntity& light, std::string_view name, const LightContext& context) {
    auto emission = spectrum_or(light.parameters, name, Rgb(1), SpectrumRole::illuminant, context.scene.color);
    if (!emission) return emission;
    auto scale = light.parameters.real_or("scale", 1);
    if (!scale) return scale.error();
    return *emission * static_cast<Real>(*scale);
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
    light.cos_zero = static_cast<Real>(std::cos(*cone * degree));
    light.cos_full = static_cast<Real>(std::cos((*cone - *delta) * degree));
    if (!(light.cos_full > light.cos_zero)) light.cos_full = light.cos_zero + unit_roundoff;  // a hard edge
    light.position = placed(source.to_world, *from);
    light.direction = direction_in_world(source.to_world, *from, *to);
    // pbrt's k_e for "power": full inside the falloff, half of it on average within.
    const Real solid_angle = 2 * pi * ((1 - light.cos_full) + (light.cos_full - light.cos_zero) / 2);
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

/// Relative file names are looked up beside the scene file that names them.
std::string resolve_path(const std::string& name, const std::string& beside) {
    const std::filesystem::path path(name);
    if (path.is_absolute()) return name;
    return (std::filesystem::path(beside).parent_path() / path).string();
}

Result<EnvironmentImage> load_environment(const SceneLight& source, const std::string& file,
                                          const LightContext& context) {
    auto image =
        read_image(resolve_path(file, source.location.file.empty() ? context.scene.file : source.location.file), "");
    if (!image) {
        Error error = image.error();
        if (!error.hint.empty()) error.hint += "; ";
        error.hint += "named by the infinite light at line " + std::to_string(source.location.line);
        return error;
    }
    if (image->width != image->height)
        return error_at(source.location, file + " is " + std::to_string(image->width) + " x " +
                                             std::to_string(image->height) +
                                             "; an equal-area octahedral environment must be square");
    const auto count = static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height);
    const bool grey = image->channels < 3;
    std::vector<Rgb> pixels(count);
    for (std::size_t i = 0; i < count; ++i) {
        const float* p = image->pixels.data() + i * static_cast<std::size_t>(image->channels);
        const Rgb c = grey ? Rgb(p[0]) : Rgb(p[0], p[1], p[2]);
        if (!is_finite(c)) return error_at(source.location, file + ": pixel " + std::to_string(i) + " is not finite");
        const auto& m = context.scene.color.rendering_from_scene;
        for (int r = 0; r < 3; ++r) {
            const auto& row = m[static_cast<std::size_t>(r)];
            pixels[i][r] = std::max(Real(0), static_cast<Real>(row[0] * c.r + row[1] * c.g + row[2] * c.b));
        }
    }
    return EnvironmentImage(image->width, std::move(pixels), Placement(source.to_world));
}

Result<Light> make_infinite(const SceneLight& source, LightContext& context) {
    if (Status s =
            refuse(source.parameters, "portal", "is not supported yet; expected an infinite light without a portal");
        !s)
        return s.error();
    Light light;
    light.kind = LightKind::uniform_environment;
    auto file = source.parameters.string_or("filename", "");
    if (!file) return file.error();
    auto illuminance = source.parameters.real_or("illuminance", -1);
    if (!illuminance) return illuminance.error();
    if (file->empty()) {
        auto radiance = scaled_emission(source, "L", context);
        if (!radiance) return radiance.error();
        light.emission =
            *illuminance > 0 ? *radiance * static_cast<Real>(*illuminance / static_cast<double>(pi)) : *radiance;
        return light;
    }
    if (Status s = refuse(source.parameters, "L", "and 'filename' exclude each other in an infinite light"); !s)
        return s.error();
    if (*illuminance > 0)
        return error_at(source.location, "'illuminance' of an image light is not supported yet; use 'scale'");
    auto scale = source.parameters.real_or("scale", 1);
    if (!scale) return scale.error();
    auto image = load_environment(source, *file, context);
    if (!image) return image.error();
    light.kind = LightKind::image_environment;
    light.emission = Rgb(static_cast<Real>(*scale));
    light.environment = static_cast<std::int32_t>(context.environments.size());
    context.environments.push_back(std::move(*image));
    return light;
}

Result<AreaEmission> make_diffuse(const SceneAreaLight& source, LightContext& context) {
    for (const char* name : {"power", "filename"})
        if (Status s = refuse(source.parameters, name,
                              "of an area light is not supported yet; give radiance as 'L' and 'scale'");
            !s)
            return s.error();
    auto radiance = scaled_emission(source, "L", context);
    if (!radiance) return radiance.error();
    auto two_sided = source.parameters.boolean_or("twosided", false);
    if (!two_sided) return two_sided.error();
    return AreaEmission{*radiance, *two_sided};
}

const ParameterDescription scale_parameter{"scale", ParameterType::real, "1", "factor on the emission"};

Registry<LightFactory> make_lights() {
    using T = ParameterType;
    Registry<LightFactory> registry("light source");
    registry.add({"point",
                  "a point that shines equally in all directions",
                  {{"I", T::rgb, "1 1 1", "radiant intensity"},
                   scale_parameter,
                   {"power", T::real, "", "total power instead of I's"},
                   {"from", T::point3, "0 0 0", "position"}},
                  make_point});
    registry.add({"spot",
                  "a point that shines into a cone",
                  {{"I", T::rgb, "1 1 1", "radiant intensity on the axis"},
                   scale_parameter,
                   {"power", T::real, "", "total power instead of I's"},
                   {"from", T::point3, "0 0 0", "position"},
                   {"to", T::point3, "0 0 1", "a point on the axis"},
                   {"coneangle", T::real, "30", "degrees from the axis where light ends"},
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
                   {"illuminance", T::real, "", "of a surface facing it (uniform lights)"}},
                  make_infinite});
    return registry;
}

}  // namespace

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
                {"twosided", ParameterType::boolean, "false", "both sides shine"}},
               make_diffuse});
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
