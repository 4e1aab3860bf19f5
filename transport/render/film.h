// The size of the image, and what of it is rendered.
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

/// As the Film directive says, or `resolution` instead. Errors: no size for an image, a crop that is no part of it.
/// What else of the directive cannot be honoured is a warning.
Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings);

/// The AOVs that film 'gbuffer' stands for: its Albedo, P, N, Ns and uv by our names, in camera space or, by
/// "coordinatesystem" "world", in the world. Nothing for other films.
std::vector<std::string> gbuffer_layers(const SceneEntity& film);

}  // namespace raylex::transport
