// The frame buffer as one multi-part OpenEXR file. How each kind of channel is stored stands in exr_storage.h.
//
// Rows are written in bands of two million pixels at most, part after part, so that an image of which no more than a
// band is in memory (PixelImage::band_end) can be written, and its sums judged, without ever being there as a whole.
// While one part is compressed (by as many threads as there are processors, unless the library would hold more than
// half a GiB for them) the next one is resolved, so that the time is that of the encoders. Narrow images of which
// nothing is zipped are written without threads: waking them would take longer.
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
    /// String attributes of every part: seed, config, git revision ... One of more than 1024 bytes stands in part 0
    /// alone.
    std::map<std::string, std::string> attributes;
    std::vector<PartitionDeclaration> partitions;
    Chromaticities chromaticities;
    std::vector<DataPart> data_parts;  ///< written after the channels' parts
    ExrStorageTable storage = default_exr_storage();
    /// One part with the channels of all, packed as light is, which must lose no bits then: for readers that know no
    /// parts.
    bool single_part = false;
    /// The pixels that the file has, where it does not have all of the image: its data window in the display window.
    std::optional<PixelRegion> data_window;
    /// Row-major, points are columns; left out of the file when all zero. Camera space is OpenEXR's: left-handed, x
    /// right, y up, z forward. Screen space, after division by w, has the image's edges at x = -1 and 1 and y = -1
    /// (bottom) and 1.
    std::array<std::array<double, 4>, 4> world_to_camera{}, world_to_screen{};
    bool complete = true;  ///< false is recorded as attribute "raylex/incomplete"
    FileSync sync = FileSync::now;
};

/// Part 0 is `rgba` (R G B A of beauty, when there is one); every other channel is a part of its own: NAME with
/// NAME.R .G .B for colours, NAME.X .Y .Z for vectors, `z` with channel Z for depth, NAME for other single values.
/// Integers are UINT, negative numbers as two's complement. Written to a temporary name beside `path`, synced and
/// renamed; on failure an earlier file at `path` is untouched.
///
/// Header, beside OpenEXR's own chromaticities, worldToCamera and worldToNDC: `colorInteropID` (part by part; "data"
/// for what is no colour); `lpe/NAME` the expression and `lpeDialect/NAME`, `rule/NAME` how samples became pixels,
/// `space/NAME`, `statistics/NAME` ("mse of beauty"), `storage/NAME` ("float zip"), each in the channel's own part and
/// all of them in part 0; `partition/NAME` in part 0 as "beauty = first + second", and `verdict/NAME`, what split_check
/// says of the very bits in the file: "holds; ..." or "does not hold; ..." ("not judged ..." where a lossy compression
/// changes them); "raylex/incomplete".
///
/// Values beyond the range of the stored type become its largest number, NaN becomes 0 (Law 6; the frame buffer holds
/// neither for light), and `repaired/NAME` says how many; infinity stays in a channel whose miss value it is (z, VLen).
/// A partition of layers that are not there is not declared; `raylex/refusedPartition` says why. `verdicts` gets what
/// check_declared_splits would say of the file, maps of residuals and splits of lossy layers excepted.
Status write_exr(const std::string& path, const PixelImage& frame_buffer, ChannelId beauty,
                 const ImageDescription& description, std::vector<SplitVerdict>* verdicts = nullptr);

/// What the library holds until a file of these channels is closed, stored as by default.
[[nodiscard]] std::uint64_t exr_writing_bytes(std::span<const ChannelDefinition> channels, ChannelId beauty, int width);

/// Whether write_exr could lay these channels out; ask before rendering. Errors: a name that is empty, used twice,
/// taken
/// ("rgba", "beauty"), longer than 244 bytes (OpenEXR's limit is 255, for "lpeDialect/NAME"), or holding a control
/// character, " + " or " = "; a partition of layers that are not there.
Status check_exr_layout(std::span<const ChannelDefinition> channels, ChannelId beauty,
                        const std::vector<PartitionDeclaration>& partitions);

}  // namespace raylex::display
