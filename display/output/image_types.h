// Data types that readers, writers and checks of images share.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"

namespace raylex::display {

enum class StoredType : std::uint8_t { half_float, single_float, unsigned_int };

/// CIE xy of red, green, blue and white.
struct Chromaticities {
    std::array<double, 2> red{0.64, 0.33}, green{0.30, 0.60}, blue{0.15, 0.06}, white{0.3127, 0.3290};
    bool operator==(const Chromaticities&) const = default;
};

/// A declared or automatic partition: layers whose per-pixel sum must equal `of`.
struct PartitionDeclaration {
    std::string name;  ///< "auto", "shipped", or the job's name for it
    std::string of;    ///< the layer that they sum to; empty = beauty
    std::vector<std::string> layers;
};

/// A part of a file without a display channel, such as a cryptomatte: FLOAT, bit-identical to the given values.
struct DataPart {
    std::string name;
    std::vector<std::string> planes;                ///< OpenEXR channel names
    std::map<std::string, std::string> attributes;  ///< for the part's header and that of part 0
    /// The values of whole rows [y0, y1): plane after plane, rows from the top. Called once per row during writing.
    std::function<std::vector<float>(const PixelRegion&)> values;
};

}  // namespace raylex::display
