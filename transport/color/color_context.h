// The meaning of a scene's numbers as colours, and their conversion to the colours that transport computes in.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "lpe/result.h"

namespace raylex::transport {

enum class ColorSpace : std::uint8_t { srgb, dci_p3, rec2020, aces2065_1 };

/// Turns RGB triples as an image file stores them (8-bit values over 255) into linear RGB of the scene's colour space.
using FileColorConversion = std::function<void(std::span<float> rgb)>;

/// The colour spaces of a scene. Its rgb values and textures are in `scene_space`; `rendering_from_scene` (row-major)
/// converts them to the rendering space. By default both spaces are linear sRGB.
struct ColorContext {
    ColorSpace scene_space = ColorSpace::srgb;
    std::array<std::array<double, 3>, 3> rendering_from_scene{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    /// Converts light of the scene to what the film records, in scene_space: exposure and white balance, which multiply
    /// the colours of all lights (scene/film_sensor.h). Applied before rendering_from_scene.
    std::array<std::array<double, 3>, 3> sensor{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    /// Converts what the film records to the components that the film's "maxcomponentvalue" clamps.
    std::array<std::array<double, 3>, 3> measured{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    /// Returns the conversion of the colours of an image texture's file, unless its texture has an "encoding" of its
    /// own. Empty: pbrt's rule, sRGB for 8-bit files and unchanged values for float files. Called once per file.
    std::function<Result<FileColorConversion>(const std::string& path)> file_color;
};

}  // namespace raylex::transport
