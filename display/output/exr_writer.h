// The frame buffer as one multi-part OpenEXR file.
#pragma once

#include <array>
#include <map>
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
    std::string name;                  ///< "auto", "shipped", or the job's name for it
    std::string of;                    ///< layer summed to; empty = beauty
    std::vector<std::string> layers;
};

struct ImageDescription {
    std::map<std::string, std::string> attributes;      ///< string attributes of every part: seed, config, git revision ...
    std::vector<PartitionDeclaration> partitions;
    Chromaticities chromaticities;
    std::array<std::array<double, 4>, 4> world_to_camera{}, world_to_screen{};   ///< row-major, points are columns
    bool complete = true;                                ///< false is recorded as attribute "raylex/incomplete"
};

/// Part 0 is `rgba` (R G B A of beauty, when there is one); every other channel is a part of its own: NAME with
/// NAME.R .G .B for colours, NAME.X .Y .Z for vectors, `z` with channel Z for depth, NAME for other single values. All
/// FLOAT but integer channels (UINT). LPE text stands in `lpe/NAME`, partitions in `partition/NAME`. Written to a
/// temporary name beside `path`, synced and renamed; on failure an earlier file at `path` is untouched.
Status write_exr(const std::string& path, const FrameBuffer& frame_buffer, ChannelId beauty, const ImageDescription& description);

}  // namespace raylex::display
