// Reads any flat OpenEXR file as named layers: single-part or multi-part, tiled or scanline, from any writer.
//
// Layer names. A channel "A.B.R" is plane R of layer "A.B", whatever the name of its part. Nameless colour channels (R
// G B A, Y) form the layer "" if the file has one part, or if the first part is named rgba, rgb, main or image;
// otherwise a layer with the name of their part. Other nameless channels (Z, id) form the layer of their part if it has
// no colour; otherwise each is a layer of its own. If two parts give the same plane to one name, the second one gets
// the prefix "PART.". Deep parts are skipped. Of a mip map only the highest level is read.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "display/buffer/frame_buffer/banded_image.h"
#include "display/output/image_types.h"
#include "lpe/result.h"

namespace raylex::display {

/// The loss that a part's compression caused in a plane, beyond that of its type. PXR24 keeps 24 bits of a float; B44
/// (half) and DWA (half and float planes named R G B Y RY BY) are lossy by perception; all others are exact.
enum class PlaneLoss : std::uint8_t { none, pxr24, b44, dwa };

/// One plane of a layer, row-major from the top of the display window; pixels outside the data window are 0. Unsigned
/// integers are rounded to float, exactly up to 2^24.
struct ImagePlane {
    std::string name;  ///< last component of the channel name: "R", "Z", ...
    StoredType stored = StoredType::single_float;
    std::vector<float> values;
    PlaneLoss loss = PlaneLoss::none;
    float dwa_level = 45;   ///< compression level of DWA, 45 if the file does not contain it
    int part = 0;           ///< index of the part in the file
    std::string channel{};  ///< full name of the channel in the file
};

/// The channels with a common name before the last dot, or the nameless channels of a part.
struct ImageLayer {
    std::string name;  ///< layer name; empty for a file's nameless R G B A
    std::string part;
    std::vector<ImagePlane> planes;  ///< R G B (A) come first, in this order, if present

    /// Finds a plane by name; if there is none, ignoring case.
    [[nodiscard]] const ImagePlane* plane(std::string_view plane_name) const;
    [[nodiscard]] bool is_color() const;  ///< has R, G and B
    /// R, G and B for arithmetic (or X Y Z, or the only plane besides A three times); three null pointers otherwise.
    [[nodiscard]] std::array<const ImagePlane*, 3> triple() const;
};

struct ExrImage {
    std::string path;
    int width = 0, height = 0;               ///< of the display window
    std::optional<PixelRegion> data_window;  ///< pixels with values, if not all; the others are 0
    std::vector<ImageLayer> layers;
    std::map<std::string, std::string> attributes;  ///< string attributes of all parts
    std::optional<Chromaticities> chromaticities;
    std::vector<PartitionDeclaration> partitions;  ///< from "partition/NAME" attributes

    /// Finds a layer by name. "" denotes the nameless R G B, or else a layer named beauty. "beauty", "rgba", "rgb",
    /// "image" and "main" (in any case), and the name of its part, denote the nameless R G B unless a layer has that
    /// name.
    [[nodiscard]] const ImageLayer* layer(std::string_view name) const;
    /// Finds a layer by name with more fallbacks, and is what every command uses: for the beauty the names of other
    /// renderers (Combined, Ci, ...); a layer with this name after a prefix that is unambiguous ("DiffDir" is
    /// "ViewLayer.DiffDir", and "diffuse" is "shot_diffuse" if all names begin with "shot_"); the layer of the part
    /// with this name, for a cryptomatte the one of the first ranks. Otherwise an error lists similar and existing
    /// names.
    [[nodiscard]] Result<const ImageLayer*> require_layer(std::string_view name) const;
    [[nodiscard]] std::vector<std::string> layer_names() const;
};

/// Reads a file. Errors: no such file, not an OpenEXR file, truncated or damaged, incomplete, only deep parts, more
/// pixels than fit in memory.
Result<ExrImage> read_exr(const std::string& path);

/// A file that is read in bands of rows, for images that do not fit in memory. The library's memory for a part is held
/// as long as this object exists.
class ExrBands {
  public:
    /// Opens the file. Errors: those of read_exr(), except problems inside the pixels.
    static Result<ExrBands> open(const std::string& path);
    ExrBands(ExrBands&&) noexcept;
    ExrBands& operator=(ExrBands&&) noexcept;
    ~ExrBands();

    /// The image without pixels: its planes have no values.
    [[nodiscard]] const ExrImage& image() const { return image_; }
    /// Bands from top to bottom. Each has as many rows as fit in `bytes`, and at least one.
    [[nodiscard]] std::vector<RowRange> bands(std::uint64_t bytes) const;
    /// Reads these rows as an image of their height.
    [[nodiscard]] Result<ExrImage> read(const RowRange& rows) const;
    /// The memory in bytes for reading the whole image.
    [[nodiscard]] double bytes_at_once() const;

  private:
    struct File;
    ExrBands();
    ExrImage image_;
    std::unique_ptr<File> file_;
};

/// Reads several files of one image, one layer per file: a nameless RGB gets the base name of the file (without a frame
/// number) as its layer name. Other layers keep their names, with the prefix "BASE." if the name is taken. Sizes and
/// chromaticities must be equal.
Result<ExrImage> read_exr_set(const std::vector<std::string>& paths);

}  // namespace raylex::display
