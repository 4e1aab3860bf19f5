// The size of the image, and the part that is rendered.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct FilmSettings {
    int width = 1280, height = 720;  ///< pixels
    double diagonal = 35;            ///< millimetres, for cameras whose film has a size
    std::optional<display::PixelRegion> crop;
};

/// Reads the Film directive; `resolution` overrides its size. Errors: an invalid image size, a crop that is not inside
/// the image. Other settings that raylex does not support are warnings.
Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings);

/// The AOVs for film 'gbuffer': its Albedo, P, N, Ns and uv by raylex's names, in camera space or, with
/// "coordinatesystem" "world", in the world. Empty for other films.
std::vector<std::string> gbuffer_layers(const SceneEntity& film);

}  // namespace raylex::transport
