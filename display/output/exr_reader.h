// Any flat OpenEXR file as named layers: one part, many parts, tiled or scanline, ours or somebody else's.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "display/output/exr_writer.h"
#include "lpe/result.h"

namespace raylex::display {

enum class StoredType : std::uint8_t { half_float, single_float, unsigned_int };

/// One plane of a layer, row-major from the top of the display window; pixels outside the data window are 0.
struct ImagePlane {
    std::string name;                   ///< last component of the channel name: "R", "Z", ...
    StoredType stored = StoredType::single_float;
    std::vector<float> values;
};

/// Channels that share everything before their name's last dot, or a part's nameless channels.
struct ImageLayer {
    std::string name;                   ///< layer name; empty for a file's nameless R G B A
    std::string part;
    std::vector<ImagePlane> planes;     ///< R G B (A) first and in that order when present

    [[nodiscard]] const ImagePlane* plane(std::string_view plane_name) const;
    /// R, G and B (or X Y Z, or a single plane three times) for arithmetic.
    [[nodiscard]] std::array<const ImagePlane*, 3> triple() const;
};

struct ExrImage {
    std::string path;
    int width = 0, height = 0;
    std::vector<ImageLayer> layers;
    std::map<std::string, std::string> attributes;          ///< string attributes over all parts
    std::optional<Chromaticities> chromaticities;
    std::vector<PartitionDeclaration> partitions;           ///< from "partition/NAME" attributes

    /// "" and "beauty" both mean the nameless R G B unless a layer is called beauty.
    [[nodiscard]] const ImageLayer* layer(std::string_view name) const;
};

Result<ExrImage> read_exr(const std::string& path);
/// Several files of one image, one layer per file: a nameless RGB takes the file's base name as its layer name.
Result<ExrImage> read_exr_set(const std::vector<std::string>& paths);

}  // namespace raylex::display
