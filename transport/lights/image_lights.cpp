// Lights that emit images: pbrt-v4's infinite, goniometric and projection lights, and area lights with "filename".
// Factors follow its file format: "power" and "illuminance" replace the value of the image itself.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "display/services/short_number.h"
#include "transport/color/color_space.h"
#include "transport/color/spectrum.h"
#include "transport/files/images/image.h"
#include "transport/lights/light_factories.h"

namespace raylex::transport {
namespace {

/// Resolves relative file names in the folder of the scene file that contains them.
std::string resolve_path(const std::string& name, const std::string& beside) {
    const std::filesystem::path path(name);
    if (path.is_absolute()) return name;
    return (std::filesystem::path(beside).parent_path() / path).string();
}

Result<std::string> required_file(const SceneEntity& source) {
    auto file = source.parameters.string_or("filename", "");
    if (file && file->empty())
        return error_at(source.location,
                        "a " + source.type + " light without 'filename'; expected the image that it shows");
    return file;
}

Status require_square(const RgbImage& image, const SceneEntity& source, const std::string& file) {
    if (image.width == image.height) return success();
    return error_at(source.location, file + " is " + std::to_string(image.width) + " x " +
                                         std::to_string(image.height) +
                                         "; an equal-area octahedral image must be square");
}

/// The factor on an image of power (or illuminance) `given` that makes it `wanted`.
Result<Real> factor_for(const SceneEntity& source, const char* name, double scale, double wanted, double given) {
    if (!(wanted > 0)) return static_cast<Real>(scale);
    if (!(given > 0))
        return error_at(source.location, std::string("'") + name + "' of this " + source.type +
                                             " light has a positive value, but its image is black");
    return static_cast<Real>(scale * wanted / given);
}

/// The illuminance on a surface that faces +z of an equal-area image, where each pixel covers the solid angle 4 pi /
/// pixels. pbrt-v4 uses half of that.
double illuminance_of(const RgbImage& image) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const Vec3 w =
                direction_from_octahedral({(static_cast<Real>(x) + Real(0.5)) / static_cast<Real>(image.width),
                                           (static_cast<Real>(y) + Real(0.5)) / static_cast<Real>(image.height)});
            if (w.z > 0) sum += double{luminance(image.at(x, y))} * double{w.z};
        }
    return sum * 2 * std::numbers::pi / static_cast<double>(image.pixels.size());
}

Result<PortalImage::Corners> read_portal(const Parameter& portal, const RenderSpace& space) {
    if (portal.type != ParameterType::point3 || portal.numbers.size() != 12)
        return error_at(portal.location, "'portal' must be four point3, the corners of a rectangle");
    PortalImage::Corners corners;
    for (std::size_t i = 0; i < 4; ++i)
        corners[i] = DVec3{portal.numbers[3 * i], portal.numbers[3 * i + 1], portal.numbers[3 * i + 2]} - space.origin;
    if (const auto problem = PortalImage::problem_of(corners))
        return error_at(portal.location, "'portal' is not a rectangle: " + *problem);
    return corners;
}

struct Sky {
    RgbImage image;
    Real factor = 1;
};

/// Reads the image of an infinite light, with its factor; without a file, a portal has an image of constant L. As
/// pbrt-v4, it does not divide by the luminance of L here, and takes "illuminance" as that of an image with all of its
/// light at the zenith.
Result<Sky> read_sky(const SceneLight& source, const std::string& file, double illuminance, LightContext& context) {
    Sky sky;
    if (file.empty()) {
        auto radiance = scaled_emission(source, "L", context);
        if (!radiance) return radiance.error();
        constexpr int resolution = 64;  // so that directions drawn by pixel are nearly uniform
        sky.image = {resolution, resolution, std::vector<Rgb>(std::size_t{resolution} * resolution, *radiance)};
        if (illuminance > 0) {
            sky.factor = static_cast<Real>(illuminance / (2 * std::numbers::pi));
        } else if (const Parameter* given = source.parameters.find("L")) {
            const auto luminance = luminance_as_given(*given);
            if (!luminance) return luminance.error();
            sky.factor = *luminance;
        }
        return sky;
    }
    if (const Parameter* p = source.parameters.find("L"))
        return error_at(p->location, "'L' and 'filename' exclude each other in an infinite light");
    auto scale = light_scale(source);
    if (!scale) return scale.error();
    auto image = read_light_image(source, file, context);
    if (!image) return image.error();
    if (Status s = require_square(*image, source, file); !s) return s.error();
    sky.image = std::move(*image);
    const auto factor =
        factor_for(source, "illuminance", *scale, illuminance, illuminance > 0 ? illuminance_of(sky.image) : 0);
    if (!factor) return factor.error();
    sky.factor = *factor;
    record_image(sky.image, context);
    return sky;
}

}  // namespace

Result<RgbImage> read_light_image(const SceneEntity& source, const std::string& file, LightContext& context,
                                  ImageValues values) {
    auto image =
        read_image(resolve_path(file, source.location.file.empty() ? context.scene.file : source.location.file), "");
    if (!image) return named_by(image.error(), "the " + source.type + " light", source.location);
    if (const auto invalid = clear_invalid_texels(*image, NegativeTexels::cleared))
        context.warnings.push_back(
            error_at(source.location, "image '" + file + "' of a " + source.type + " light: " + *invalid));
    const auto count = static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height);
    const auto warn = [&](const std::string& warning) {
        context.warnings.push_back(
            error_at(source.location, "image '" + file + "' of a " + source.type + " light: " + warning));
    };
    if (!image->warning.empty()) warn(image->warning);
    if (image->other_space && values == ImageValues::colours) warn(space_is_unknown);
    const bool grey = image->channels < 3;
    const ColorSpace space = context.scene.color.scene_space;
    const Matrix3 to_scene = rgb_from_rgb(space, image->space, false);
    RgbImage result{image->width, image->height, std::vector<Rgb>(count)};
    for (std::size_t i = 0; i < count; ++i) {
        const float* p = image->pixels.data() + i * static_cast<std::size_t>(image->channels);
        result.pixels[i] = grey ? Rgb(p[0]) : Rgb(p[0], p[1], p[2]);
        if (image->space == space || values == ImageValues::plain) continue;
        const Rgb& stored = result.pixels[i];
        const Triple c = multiply(to_scene, Triple{double{stored.r}, double{stored.g}, double{stored.b}});
        result.pixels[i] = Rgb(static_cast<Real>(c[0]), static_cast<Real>(c[1]), static_cast<Real>(c[2]));
    }
    return result;
}

void record_image(RgbImage& image, const LightContext& context) {
    for (Rgb& pixel : image.pixels) pixel = recorded_light(pixel, context.scene.color);
}

Result<Light> make_infinite(const SceneLight& source, LightContext& context) {
    Light light;
    light.kind = LightKind::uniform_environment;
    auto file = source.parameters.string_or("filename", "");
    if (!file) return file.error();
    auto illuminance = source.parameters.real_or("illuminance", -1);
    if (!illuminance) return illuminance.error();
    const Parameter* portal = source.parameters.find("portal");
    if (file->empty() && portal == nullptr) {
        auto radiance = scaled_emission(source, "L", context);
        if (!radiance) return radiance.error();
        light.emission =
            *illuminance > 0 ? *radiance * static_cast<Real>(*illuminance / static_cast<double>(pi)) : *radiance;
        return light;
    }
    auto sky = read_sky(source, *file, *illuminance, context);
    if (!sky) return sky.error();
    light.emission = Rgb(sky->factor);
    const Placement placement(source.to_world);
    if (portal == nullptr) {
        light.kind = LightKind::image_environment;
        light.image = static_cast<std::int32_t>(context.images.environments.size());
        context.images.environments.emplace_back(sky->image.width, std::move(sky->image.pixels), placement);
        return light;
    }
    const auto corners = read_portal(*portal, context.space);
    if (!corners) return corners.error();
    light.kind = LightKind::portal_environment;
    light.image = static_cast<std::int32_t>(context.images.portals.size());
    context.images.portals.emplace_back(sky->image, placement, *corners);
    return light;
}

Result<Light> make_goniometric(const SceneLight& source, LightContext& context) {
    Light light;
    light.kind = LightKind::goniometric;
    auto file = required_file(source);
    if (!file) return file.error();
    auto intensity = scaled_emission(source, "I", context);
    if (!intensity) return intensity.error();
    auto power = source.parameters.real_or("power", -1);
    if (!power) return power.error();
    auto image = read_light_image(source, *file, context, ImageValues::plain);
    if (!image) return image.error();
    if (Status s = require_square(*image, source, *file); !s) return s.error();
    for (Rgb& pixel : image->pixels) pixel = Rgb(pixel.average());
    auto shown = IntensityImage::goniometric(std::move(*image), Placement(source.to_world));
    const auto factor = factor_for(source, "power", 1, *power, shown.flux());
    if (!factor) return factor.error();
    light.emission = *intensity * *factor;
    light.position = Matrix34(source.to_world.matrix()).point({0, 0, 0}).to_real();
    light.power = double{luminance(light.emission)} * shown.flux();
    light.image = static_cast<std::int32_t>(context.images.intensities.size());
    context.images.intensities.push_back(std::move(shown));
    return light;
}

Result<Light> make_projection(const SceneLight& source, LightContext& context) {
    Light light;
    light.kind = LightKind::projection;
    auto file = required_file(source);
    if (!file) return file.error();
    auto scale = light_scale(source), power = source.parameters.real_or("power", -1),
         fov = source.parameters.real_or("fov", 90);
    for (const auto* each : {&scale, &power, &fov})
        if (!*each) return each->error();
    if (!(*fov > 0 && *fov < 180))
        return error_at(source.location, "'fov' is " + short_number(*fov, 6) + "; expected degrees between 0 and 180");
    auto image = read_light_image(source, *file, context);
    if (!image) return image.error();
    const Placement placement(source.to_world);
    const auto factor = factor_for(source, "power", *scale, *power,
                                   *power > 0 ? IntensityImage::projection(*image, *fov, placement).flux() : 0);
    if (!factor) return factor.error();
    record_image(*image, context);
    auto shown = IntensityImage::projection(std::move(*image), *fov, placement);
    light.emission = Rgb(*factor);
    light.position = placement.to_world.point({0, 0, 0}).to_real();
    light.direction = normalize(placement.to_world.vector({0, 0, 1})).to_real();
    light.versine_zero = shown.versine(light.direction) * (1 + Real(1e-4));
    light.versine_full = light.versine_zero;
    light.power = double{luminance(light.emission)} * shown.flux();
    light.image = static_cast<std::int32_t>(context.images.intensities.size());
    context.images.intensities.push_back(std::move(shown));
    return light;
}

Result<AreaEmission> make_diffuse_area(const SceneAreaLight& source, LightContext& context) {
    AreaEmission emission;
    auto file = source.parameters.string_or("filename", "");
    if (!file) return file.error();
    const Parameter* radiance_given = source.parameters.find("L");
    if (!file->empty() && radiance_given != nullptr)
        return error_at(radiance_given->location, "'L' and 'filename' exclude each other in a diffuse area light");
    auto radiance = scaled_emission(source, "L", context);
    if (!radiance) return radiance.error();
    auto two_sided = source.parameters.boolean_or("twosided", false);
    if (!two_sided) return two_sided.error();
    auto power = source.parameters.real_or("power", -1);
    if (!power) return power.error();
    auto scale = light_scale(source);
    if (!scale) return scale.error();
    emission.radiance = file->empty() ? *radiance : Rgb(static_cast<Real>(*scale));
    emission.two_sided = *two_sided;
    emission.power = std::max(*power, 0.0);
    if (file->empty()) return emission;
    auto image = read_light_image(source, *file, context);
    if (!image) return image.error();
    const double mean = image->mean_luminance();
    if (const auto factor = factor_for(source, "power", 1, emission.power, mean); !factor) return factor.error();
    record_image(*image, context);
    emission.image = static_cast<std::int32_t>(context.images.emissions.size());
    context.images.emissions.push_back({std::move(*image), mean});
    return emission;
}

}  // namespace raylex::transport
