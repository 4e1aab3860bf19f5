// Layers as 8-bit pictures: light through a display and view, geometry as a sensible false colour.
#pragma once

#include <string>
#include <vector>

#include "display/output/color/color_manager.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// How a layer is shown.
enum class LayerLook {
    light,      ///< scene-linear colour, through the display and view
    normal,     ///< unit vectors, -1..1 to 0..1
    position,   ///< vectors, each axis from its least to its largest finite value
    parameter,  ///< surface parameters, their fractional part
    depth,      ///< one real number, near bright, misses black
    identity,   ///< integers, a colour per value, 0 black
    mattes,     ///< a cryptomatte's layer of two ranks: a colour per id, by coverage
    value       ///< any other single real number, from its least to its largest finite value
};

/// From the layer's name and planes. "albedo" is light: it is a colour; so is luminance (a plane Y) without colours.
LayerLook look_of(const display::ImageLayer& layer);
/// The layer that is asked for by any name that means it; without one the beauty, else what other renderers' habits
/// suggest, else the first light.
Result<const display::ImageLayer*> shown_layer(const display::ExrImage& image, const std::string& name);
/// One short line for a reader: "camera-space normal, -1..1 shown as 0..1".
const char* describe(LayerLook look);

/// 8-bit RGB, row-major from the top.
struct Picture {
    int width = 0, height = 0;
    std::vector<unsigned char> rgb;
};

struct PictureOptions {
    int largest_side = 0;       ///< reduced by averaging blocks (nearest for geometry) until it fits; 0 = as it is
    double exposure = 0;        ///< stops, light only
    std::string display, view;  ///< empty: the config's defaults
};

/// Luminance with OpenEXR's chroma (Y RY BY) is shown in colour. Planes of other names than R G B or X Y Z are shown as
/// red, green and blue in their order, alpha left out; of more than three the first three.
Result<Picture> picture_of(const display::ExrImage& image, const display::ImageLayer& layer,
                           const display::ColorManager& color, const PictureOptions& options);

}  // namespace raylex::experiments
