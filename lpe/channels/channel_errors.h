// Errors about single channels of a file. Readers continue after such an error, so that one run reports all of them.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/channels/channel_file.h"
#include "lpe/failure.h"

namespace raylex::lpe {

/// A reader throws this at the end of the file. A handler of Failure gets the first error.
struct ChannelErrors : Failure {
    std::vector<Error> errors;
    ChannelFile file;  ///< the channels without errors
};

/// Parses a channel file. Unlike parse_channel_file(), it does not stop at the first error: errors about single
/// channels go to `errors`, and the other channels are returned.
Result<ChannelFile> parse_channels(std::string_view text, const std::string& origin, ChannelFormat format,
                                   std::vector<Error>& errors);

}  // namespace raylex::lpe
