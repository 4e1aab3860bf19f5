// What the registry's factories share: image_lights.cpp makes the lights that show images, light_registry.cpp the
// others.
#pragma once

#include <string>

#include "transport/lights/light_table.h"

namespace raylex::transport {

/// "scale", not negative.
Result<double> light_scale(const SceneEntity& light);
/// The colour parameter `name` times "scale".
Result<Rgb> scaled_emission(const SceneEntity& light, std::string_view name, const LightContext& context);

/// What the values of an image mean: colours are taken to the scene's space, as the light that they are (no white is
/// adapted); plain ones, which are averaged, stay as they are stored.
enum class ImageValues : std::uint8_t { colours, plain };
/// The image of the light's "filename", which must be given: linear. Values that are negative or not finite are taken
/// as 0, with a warning; in the scene's space there may be negative ones, of colours that it cannot show.
Result<RgbImage> read_light_image(const SceneEntity& light, const std::string& file, LightContext& context,
                                  ImageValues values = ImageValues::colours);

/// Turns such an image into light as it is recorded, in the rendering space (recorded_light()).
void record_image(RgbImage& image, const LightContext& context);

Result<Light> make_infinite(const SceneLight& source, LightContext& context);
Result<Light> make_goniometric(const SceneLight& source, LightContext& context);
Result<Light> make_projection(const SceneLight& source, LightContext& context);
Result<AreaEmission> make_diffuse_area(const SceneAreaLight& source, LightContext& context);

}  // namespace raylex::transport
