// Writes the frame buffer as one multi-part OpenEXR file. exr_storage.h defines the storage of each kind of channel.
//
// Rows are written in bands of at most two million pixels, part after part. So an image of which only one band is in
// memory (PixelImage::band_end) can be written and its sums checked. While one part is compressed, the next one is
// resolved, so the total time is that of the encoders. They use as many threads as there are processors, unless the
// library would need more than half a GiB for them. Narrow images without zip are written without threads, because
// waking them would take longer.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/output/atomic_file.h"
#include "display/output/image_types.h"
#include "display/output/splits/split_check.h"
#include "display/output/writer/exr_storage.h"
#include "lpe/result.h"

namespace raylex::display {

struct ImageDescription {
    /// String attributes of every part: seed, config, git revision ... An attribute of more than 1024 bytes is only in
    /// part 0.
    std::map<std::string, std::string> attributes;
    std::vector<PartitionDeclaration> partitions;
    Chromaticities chromaticities;
    std::vector<DataPart> data_parts;  ///< written after the parts of the channels
    ExrStorageTable storage = default_exr_storage();
    /// Writes a single part with all channels, packed like light, which must be lossless then: for readers that do not
    /// support parts.
    bool single_part = false;
    /// The pixels in the file if it does not contain the whole image: its data window in the display window.
    std::optional<PixelRegion> data_window;
    /// Row-major matrices that multiply column vectors; omitted from the file if all zero. Camera space is that of
    /// OpenEXR: left-handed, x right, y up, z forward. In screen space, after division by w, the edges of the image are
    /// at x = -1 and 1, and y = -1 (bottom) and 1.
    std::array<std::array<double, 4>, 4> world_to_camera{}, world_to_screen{};
    bool complete = true;  ///< false is written as attribute "raylex/incomplete"
    FileSync sync = FileSync::now;
};

/// Part 0 is `rgba` (R G B A of beauty, if there is one). Every other channel is a part of its own: NAME with NAME.R .G
/// .B for colours, NAME.X .Y .Z for vectors, `z` with channel Z for depth, NAME for other single values. Integers are
/// UINT, negative numbers in two's complement. The file is written to a temporary name beside `path`, synced and
/// renamed; on failure an earlier file at `path` is unchanged.
///
/// The header contains, beside OpenEXR's chromaticities, worldToCamera and worldToNDC: `colorInteropID` (per part;
/// "data" for parts that are not colours); `lpe/NAME` (expression), `lpeDialect/NAME`, `rule/NAME` (how samples became
/// pixels), `space/NAME`, `statistics/NAME` ("mse of beauty"), `storage/NAME` ("float zip"), each in the channel's part
/// and all of them in part 0; in part 0 `partition/NAME` as "beauty = first + second", and `verdict/NAME`, the result
/// of split_check for the exact bits in the file: "holds; ..." or "does not hold; ..." ("not judged ..." if a lossy
/// compression changes them); "raylex/incomplete".
///
/// Values beyond the range of the stored type become its largest number, and NaN becomes 0 (Law 6; for light the frame
/// buffer contains neither); `repaired/NAME` has their number. Infinity stays in a channel whose miss value it is (z,
/// VLen). A partition with missing layers is not declared; `raylex/refusedPartition` gives the reason. `verdicts` gets
/// the results of check_declared_splits() for the file, without maps of residuals and without splits of lossy layers.
Status write_exr(const std::string& path, const PixelImage& frame_buffer, ChannelId beauty,
                 const ImageDescription& description, std::vector<SplitResult>* results = nullptr);

/// The library's memory until a file of these channels, with the default storage, is closed.
[[nodiscard]] std::uint64_t exr_writing_bytes(std::span<const ChannelDefinition> channels, ChannelId beauty, int width);

/// Checks that write_exr() can write these channels; call it before rendering. Errors: a name that is empty, used
/// twice, reserved ("rgba", "beauty"), longer than 244 bytes (OpenEXR's limit is 255, for "lpeDialect/NAME"), or that
/// contains a control character, " + " or " = "; a partition with missing layers.
Status check_exr_layout(std::span<const ChannelDefinition> channels, ChannelId beauty,
                        const std::vector<PartitionDeclaration>& partitions);

}  // namespace raylex::display
