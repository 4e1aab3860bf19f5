#include "display/services/samples/refusals.h"

#include <numeric>

#include "display/services/channel_settings.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

std::uint64_t RefusalCounts::total() const {
    return std::accumulate(by.begin(), by.end(), std::uint64_t{0});
}

void RefusalCounts::add(const RefusalCounts& other) {
    for (std::size_t i = 0; i < by.size(); ++i) by[i] += other.by[i];
}

std::vector<std::string> refusal_warnings(std::span<const ChannelDefinition> channels,
                                          std::span<const RefusalCounts> refusals) {
    std::vector<std::string> warnings;
    for (std::size_t i = 0; i < refusals.size(); ++i) {
        if (refusals[i].total() == 0) continue;
        const bool channel = i < channels.size();
        const std::string reasons[] = {
            channel ? "to a layer that uses another channel's samples" : "with ids that are not channels",
            "to rows outside the batch",
            channel ? "whose type differs from the channel's type " + std::string(type_name(channels[i].type))
                    : std::string(),
            "with values that are not finite or out of range",
            "for a camera ray that has " + std::to_string(SampleTable::most_extra_rows) + " extra rows, the maximum",
            "to discard an iteration with splats that were already in the image"};
        std::string list;
        for (std::size_t k = 0; k < refusals[i].by.size(); ++k)
            if (const std::uint64_t count = refusals[i].by[k]; count > 0)
                list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + reasons[k];
        const std::uint64_t total = refusals[i].total();
        warnings.push_back((channel ? "channel '" + channels[i].name + "'" : std::string("the display services")) +
                           " refused " + std::to_string(total) + (total == 1 ? " call: " : " calls: ") + list);
    }
    return warnings;
}

}  // namespace raylex::display
