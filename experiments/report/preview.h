// Layers as 8-bit pictures: light through a display and view, geometry in false colours.
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
    mattes,     ///< two ranks of a cryptomatte: a colour per id, weighted by coverage
    value       ///< any other single real number, from its least to its largest finite value
};

/// The look that fits the layer's name and planes. Albedo and plain luminance (a plane Y alone) are shown as light.
LayerLook look_of(const display::ImageLayer& layer);
/// The layer of that name. If `name` is empty: the beauty, else the layer that other renderers use for it, else the
/// first layer with light.
Result<const display::ImageLayer*> shown_layer(const display::ExrImage& image, const std::string& name);
/// One short line for readers, such as "unit vectors: -1 to 1 shown as 0 to 1"; empty for light.
const char* describe(LayerLook look);

/// 8-bit RGB, row-major from the top.
struct Picture {
    int width = 0, height = 0;
    std::vector<unsigned char> rgb;
};

struct PictureOptions {
    int largest_side = 0;       ///< larger images are reduced: means over blocks (nearest for geometry); 0: full size
    double exposure = 0;        ///< stops, light only
    std::string display, view;  ///< empty: the config's defaults
};

/// Luminance with OpenEXR's chroma (Y RY BY) is shown in colour. If the planes are not named R G B or X Y Z, the first
/// three other than alpha are shown as red, green and blue.
Result<Picture> picture_of(const display::ExrImage& image, const display::ImageLayer& layer,
                           const display::ColorManager& color, const PictureOptions& options);

}  // namespace raylex::experiments
