// What the registry's factories share: image_lights.cpp makes the lights that show images, light_registry.cpp the
// others.
#pragma once

#include <string>

#include "transport/lights/light_table.h"

namespace raylex::transport {

/// The colour parameter `name` times "scale".
Result<Rgb> scaled_emission(const SceneEntity& light, std::string_view name, const LightContext& context);

/// The image of the light's "filename", which must be given, as it is stored: linear, in the scene's space. Values that
/// are negative or not finite are taken as 0, with a warning.
Result<RgbImage> read_light_image(const SceneEntity& light, const std::string& file, LightContext& context);

/// Turns such an image into light as it is recorded, in the rendering space (recorded_light()).
void record_image(RgbImage& image, const LightContext& context);

Result<Light> make_infinite(const SceneLight& source, LightContext& context);
Result<Light> make_goniometric(const SceneLight& source, LightContext& context);
Result<Light> make_projection(const SceneLight& source, LightContext& context);
Result<AreaEmission> make_diffuse_area(const SceneAreaLight& source, LightContext& context);

}  // namespace raylex::transport
