// Calls of the display services that were refused: why, how often, and what the user reads of it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"

namespace raylex::display {

/// Why a call was refused.
enum class Refusal : std::uint8_t {
    unknown_channel,  ///< the id is neither a channel of this render nor invalid_channel
    unknown_row,      ///< the row is none of this batch
    wrong_type,       ///< the channel holds another type
    bad_value,        ///< not finite (Law 6), or a negative surface number
    no_room,          ///< add_sample: the camera ray has SampleTable::most_extra_rows extra rows already
    too_late          ///< discard_iteration: splats of the iteration are in the image already
};
inline constexpr int refusal_kinds = 6;

/// Refused calls by reason.
struct RefusalCounts {
    std::array<std::uint64_t, refusal_kinds> by{};

    [[nodiscard]] std::uint64_t of(Refusal reason) const { return by[static_cast<std::size_t>(reason)]; }
    [[nodiscard]] std::uint64_t total() const;
    void add(const RefusalCounts& other);
    bool operator==(const RefusalCounts&) const = default;
};

/// One sentence for each channel that refused calls, with how many and why; calls that name no channel come last.
/// `refusals` has an entry for each channel and one more.
std::vector<std::string> refusal_warnings(std::span<const ChannelDefinition> channels,
                                          std::span<const RefusalCounts> refusals);

}  // namespace raylex::display
