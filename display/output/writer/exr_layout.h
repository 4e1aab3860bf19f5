// Plans the parts and channels of a file for the channels of a frame buffer, and the contents of the headers.
#pragma once

#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"

namespace raylex::display {

struct PlannedPart {
    ChannelId channel = invalid_channel;
    const DataPart* data = nullptr;  ///< instead of a channel; owned by the ImageDescription
    std::string name;
    std::vector<std::string> planes;  ///< OpenEXR channel names, in the order of the channel's components
    ExrStorage storage;
    bool alpha = false;  ///< the last plane is coverage
    std::map<std::string, std::string> attributes;
};

/// The limit per file; OpenEXR needs 60 kB of memory per part during writing, whatever its pixels.
inline constexpr std::size_t most_layers = 4096;
/// The subset of check_exr_layout() without which no file can be written.
Status check_channel_names(std::span<const ChannelDefinition> channels, ChannelId beauty);

/// The value of a `verdict/NAME` attribute until the pixels are known: a unique text of result_length bytes.
[[nodiscard]] std::string result_placeholder(std::size_t partition);
inline constexpr std::size_t result_length = 224;

/// Returns whether the layers of the partition and the layer that they split all exist, by the rules of plan_parts().
[[nodiscard]] bool is_declared(std::span<const ChannelDefinition> channels, ChannelId beauty,
                               const PartitionDeclaration& partition);

/// Plans the parts: first the part with the beauty, then, in the order of the channels, those that Blender can use,
/// then the others, and integers last.
std::vector<PlannedPart> plan_parts(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                    const ImageDescription& description);

}  // namespace raylex::display
