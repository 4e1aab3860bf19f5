// What is wrong with single channels of a file: readers go on behind it, so that every such error is known at once.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/channels/channel_file.h"
#include "lpe/failure.h"

namespace raylex::lpe {

/// What a reader throws at the file's end. Whoever catches a Failure has the first error.
struct ChannelErrors : Failure {
    std::vector<Error> errors;
    ChannelFile file;  ///< the channels without one
};

/// As parse_channel_file, which ends at the first error; here those of single channels are added to `errors`, and the
/// others are returned.
Result<ChannelFile> parse_channels(std::string_view text, const std::string& origin, ChannelFormat format,
                                   std::vector<Error>& errors);

}  // namespace raylex::lpe
