// The size of the image.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct FilmSettings {
    int width = 1280, height = 720;  ///< pixels
};

/// As the Film directive says, or `resolution` instead. Errors: no size for an image, crop windows. What else of the
/// directive cannot be honoured is a warning.
Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings);

}  // namespace raylex::transport
