// Refused calls of the display services: reasons, counts and warnings.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"

namespace raylex::display {

/// The reason of a refusal.
enum class Refusal : std::uint8_t {
    unknown_channel,  ///< the id is neither a channel of this render nor invalid_channel
    unknown_row,      ///< the row is not in this batch
    wrong_type,       ///< the channel has another type
    bad_value,        ///< not finite (Law 6), or a negative surface number
    no_room,          ///< add_sample: the camera ray already has SampleTable::most_extra_rows extra rows
    too_late          ///< discard_iteration: splats of the iteration are already in the image
};
inline constexpr int refusal_kinds = 6;

/// Counts of refused calls by reason.
struct RefusalCounts {
    std::array<std::uint64_t, refusal_kinds> by{};

    [[nodiscard]] std::uint64_t of(Refusal reason) const { return by[static_cast<std::size_t>(reason)]; }
    [[nodiscard]] std::uint64_t total() const;
    void add(const RefusalCounts& other);
    bool operator==(const RefusalCounts&) const = default;
};

/// One warning for each channel that refused calls, with counts and reasons; calls without a channel come last.
/// `refusals` has one entry per channel, plus one.
std::vector<std::string> refusal_warnings(std::span<const ChannelDefinition> channels,
                                          std::span<const RefusalCounts> refusals);

}  // namespace raylex::display
