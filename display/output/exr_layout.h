// Which parts and channels a frame buffer's channels become in a file, and what the headers say.
#pragma once

#include <string>
#include <vector>

#include "display/output/exr_writer.h"

namespace raylex::display {

struct PlannedPart {
    ChannelId channel = invalid_channel;
    std::string name;
    std::vector<std::string> planes;  ///< OpenEXR channel names, in the order of the channel's components
    bool integer = false;
    bool alpha = false;  ///< the last plane is coverage
    std::map<std::string, std::string> attributes;
};

/// The part of check_exr_layout without which no file can be written.
Status check_channel_names(std::span<const ChannelDefinition> channels, ChannelId beauty);

std::vector<PlannedPart> plan_parts(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                    const ImageDescription& description);

}  // namespace raylex::display
