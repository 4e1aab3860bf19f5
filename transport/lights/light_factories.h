// Helpers of the registry's factories: image_lights.cpp makes the lights with images, light_registry.cpp the others.
#pragma once

#include <string>

#include "transport/lights/light_table.h"

namespace raylex::transport {

/// The parameter "scale", which must not be negative.
Result<double> light_scale(const SceneEntity& light);
/// The colour parameter `name` times "scale".
Result<Rgb> scaled_emission(const SceneEntity& light, std::string_view name, const LightContext& context);

/// The meaning of an image's values. `colours` are converted to the scene's space as light (without white adaptation);
/// `plain` ones, which are averaged, stay as they are stored.
enum class ImageValues : std::uint8_t { colours, plain };
/// Reads the image of the light's "filename", which must be given, as linear values. Negative values and those that are
/// not finite become 0, with a warning. In the scene's space, colours outside its gamut may have negative values.
Result<RgbImage> read_light_image(const SceneEntity& light, const std::string& file, LightContext& context,
                                  ImageValues values = ImageValues::colours);

/// Converts such an image to light as the film records it, in the rendering space (recorded_light()).
void record_image(RgbImage& image, const LightContext& context);

Result<Light> make_infinite(const SceneLight& source, LightContext& context);
Result<Light> make_goniometric(const SceneLight& source, LightContext& context);
Result<Light> make_projection(const SceneLight& source, LightContext& context);
Result<AreaEmission> make_diffuse_area(const SceneAreaLight& source, LightContext& context);

}  // namespace raylex::transport
