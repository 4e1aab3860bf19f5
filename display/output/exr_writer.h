// The frame buffer as one multi-part OpenEXR file.
//
// Compression is ZIP: lossless for 32-bit float and integers (PXR24, B44 and DWA are not, and Law 1 is about the bits
// in the file), read by everything, and its blocks of 16 lines pack better than ZIPS's single ones.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer.h"
#include "lpe/result.h"

namespace raylex::display {

/// CIE xy of red, green, blue and white.
struct Chromaticities {
    std::array<double, 2> red{0.64, 0.33}, green{0.30, 0.60}, blue{0.15, 0.06}, white{0.3127, 0.3290};
    bool operator==(const Chromaticities&) const = default;
};

/// A declared or automatic partition: layers whose per-pixel sum must equal `of`.
struct PartitionDeclaration {
    std::string name;  ///< "auto", "shipped", or the job's name for it
    std::string of;    ///< layer summed to; empty = beauty
    std::vector<std::string> layers;
};

struct ImageDescription {
    /// String attributes of every part: seed, config, git revision ... One of more than 1024 bytes stands in part 0
    /// alone.
    std::map<std::string, std::string> attributes;
    std::vector<PartitionDeclaration> partitions;
    Chromaticities chromaticities;
    /// Row-major, points are columns; left out of the file when all zero. Camera space is OpenEXR's: left-handed, x
    /// right, y up, z forward. Screen space, after division by w, has the image's edges at x = -1 and 1 and y = -1
    /// (bottom) and 1.
    std::array<std::array<double, 4>, 4> world_to_camera{}, world_to_screen{};
    bool complete = true;  ///< false is recorded as attribute "raylex/incomplete"
};

/// Part 0 is `rgba` (R G B A of beauty, when there is one); every other channel is a part of its own: NAME with
/// NAME.R .G .B for colours, NAME.X .Y .Z for vectors, `z` with channel Z for depth, NAME for other single values. All
/// FLOAT but integer channels (UINT, negative numbers as two's complement). Written to a temporary name beside `path`,
/// synced and renamed; on failure an earlier file at `path` is untouched.
///
/// Header, beside OpenEXR's own chromaticities, worldToCamera and worldToNDC: `lpe/NAME` the expression and
/// `lpeDialect/NAME`, `rule/NAME` how samples became pixels, `space/NAME`, each in the channel's own part and all of
/// them in part 0; `partition/NAME` in part 0 as "beauty = first + second"; "raylex/incomplete".
///
/// Values beyond float's range become the largest float, NaN becomes 0 (Law 6; the frame buffer holds neither for
/// light), and `repaired/NAME` says how many; infinity stays in a channel whose miss value it is (z, VLen). A partition
/// of layers that are not there is not declared; `raylex/refusedPartition` says why.
Status write_exr(const std::string& path, const FrameBuffer& frame_buffer, ChannelId beauty,
                 const ImageDescription& description);

/// Whether write_exr could lay these channels out; ask before rendering. Errors: a name that is empty, used twice, taken
/// ("rgba", "beauty"), longer than 244 bytes (OpenEXR's limit is 255, for "lpeDialect/NAME"), or holding a control
/// character, " + " or " = "; a partition of layers that are not there.
Status check_exr_layout(std::span<const ChannelDefinition> channels, ChannelId beauty,
                        const std::vector<PartitionDeclaration>& partitions);

}  // namespace raylex::display
