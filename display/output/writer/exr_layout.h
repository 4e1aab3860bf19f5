// Which parts and channels a frame buffer's channels become in a file, and what the headers say.
#pragma once

#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"

namespace raylex::display {

struct PlannedPart {
    ChannelId channel = invalid_channel;
    const DataPart* data = nullptr;  ///< instead of a channel; lives in the ImageDescription
    std::string name;
    std::vector<std::string> planes;  ///< OpenEXR channel names, in the order of the channel's components
    ExrStorage storage;
    bool alpha = false;  ///< the last plane is coverage
    std::map<std::string, std::string> attributes;
};

/// Of a file; a part of OpenEXR's takes 60 kB in memory while it is written, whatever its pixels.
inline constexpr std::size_t most_layers = 4096;
/// The part of check_exr_layout without which no file can be written.
Status check_channel_names(std::span<const ChannelDefinition> channels, ChannelId beauty);

/// The value that a `verdict/NAME` attribute has until the pixels are known: a text that occurs nowhere else, of
/// verdict_length bytes.
[[nodiscard]] std::string verdict_placeholder(std::size_t partition);
inline constexpr std::size_t verdict_length = 224;

/// Whether the partition's layers and the one they split are all there, as plan_parts judges it.
[[nodiscard]] bool is_declared(std::span<const ChannelDefinition> channels, ChannelId beauty,
                               const PartitionDeclaration& partition);

/// The part that beauty is in comes first, then in the channels' order those that Blender reads, then the others.
std::vector<PlannedPart> plan_parts(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                    const ImageDescription& description);

}  // namespace raylex::display
