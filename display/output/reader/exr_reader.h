// Any flat OpenEXR file as named layers: one part, many parts, tiled or scanline, ours or somebody else's.
//
// Layer names. A channel "A.B.R" is plane R of layer "A.B", whatever its part is called. Nameless colour channels
// (R G B A, Y) make the layer "" when the file has one part or the first part is called rgba, rgb, main or image, else
// a layer called like their part. Other nameless channels (Z, id) make the layer of their part when it has no colour;
// else each is a layer of its own. A name that two parts give to the same plane gets "PART." in front the second time.
// Deep parts are passed over. Only the highest level of a mip map is read.
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

/// What a part's compression did to a plane, beyond its type. PXR24 keeps 24 bits of a float; B44 (half) and DWA (half
/// and float planes called R G B Y RY BY) keep what the eye sees; everything else is exact.
enum class PlaneLoss : std::uint8_t { none, pxr24, b44, dwa };

/// One plane of a layer, row-major from the top of the display window; pixels outside the data window are 0. Unsigned
/// integers are rounded to float: exact up to 2^24.
struct ImagePlane {
    std::string name;  ///< last component of the channel name: "R", "Z", ...
    StoredType stored = StoredType::single_float;
    std::vector<float> values;
    PlaneLoss loss = PlaneLoss::none;
    float dwa_level = 45;  ///< of DWA: its compression level, 45 where the file does not say
};

/// Channels that share everything before their name's last dot, or a part's nameless channels.
struct ImageLayer {
    std::string name;  ///< layer name; empty for a file's nameless R G B A
    std::string part;
    std::vector<ImagePlane> planes;  ///< R G B (A) first and in that order when present

    /// By name; failing that, ignoring case.
    [[nodiscard]] const ImagePlane* plane(std::string_view plane_name) const;
    [[nodiscard]] bool is_color() const;  ///< has R, G and B
    /// R, G and B (or X Y Z, or the only plane beside A three times) for arithmetic; three null pointers for anything
    /// else.
    [[nodiscard]] std::array<const ImagePlane*, 3> triple() const;
};

struct ExrImage {
    std::string path;
    int width = 0, height = 0;               ///< of the display window
    std::optional<PixelRegion> data_window;  ///< where there are pixels, if not everywhere; the others are 0
    std::vector<ImageLayer> layers;
    std::map<std::string, std::string> attributes;  ///< string attributes over all parts
    std::optional<Chromaticities> chromaticities;
    std::vector<PartitionDeclaration> partitions;  ///< from "partition/NAME" attributes

    /// By name. "" means the nameless R G B, else a layer called beauty; "beauty", "rgba", "rgb", "image" and "main"
    /// (in any case) mean the nameless R G B unless a layer is called so, and so does the name of its part.
    [[nodiscard]] const ImageLayer* layer(std::string_view name) const;
    /// The same; failing that, for the beauty what other renderers call it (Combined, Ci, ...); the one layer that is
    /// called so behind a prefix: "DiffDir" is "ViewLayer.DiffDir", and "diffuse" is "shot_diffuse" where all names
    /// begin with "shot_"; the layer of the part called so, of a cryptomatte's the one of the first ranks. Else an
    /// error with near misses and the names there are. Every command finds its layers by this.
    [[nodiscard]] Result<const ImageLayer*> require_layer(std::string_view name) const;
    [[nodiscard]] std::vector<std::string> layer_names() const;
};

/// Errors: no such file, no OpenEXR file, truncated or damaged, incomplete, only deep parts, more pixels than fit in
/// memory.
Result<ExrImage> read_exr(const std::string& path);

/// A file that is read in bands of rows, for images that do not fit in memory. What the library keeps for a part it
/// keeps for as long as this lives.
class ExrBands {
  public:
    /// Errors: as read_exr(), but for what is in the pixels.
    static Result<ExrBands> open(const std::string& path);
    ExrBands(ExrBands&&) noexcept;
    ExrBands& operator=(ExrBands&&) noexcept;
    ~ExrBands();

    /// Everything but the pixels: planes without values.
    [[nodiscard]] const ExrImage& image() const { return image_; }
    /// From the top, each of so many rows that its planes take `bytes` at most, and of one at least.
    [[nodiscard]] std::vector<RowRange> bands(std::uint64_t bytes) const;
    /// These rows as an image of their height.
    [[nodiscard]] Result<ExrImage> read(const RowRange& rows) const;
    /// What reading the whole image would take.
    [[nodiscard]] double bytes_at_once() const;

  private:
    struct File;
    ExrBands();
    ExrImage image_;
    std::unique_ptr<File> file_;
};

/// Several files of one image, one layer per file: a nameless RGB takes the file's base name (without a frame number)
/// as its layer name. Other layers keep theirs, with "BASE." in front when it is taken. Sizes and chromaticities must
/// agree.
Result<ExrImage> read_exr_set(const std::vector<std::string>& paths);

}  // namespace raylex::display
