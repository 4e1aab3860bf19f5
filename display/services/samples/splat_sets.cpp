#include "display/services/samples/splat_sets.h"

#include <algorithm>
#include <bit>
#include <map>

namespace raylex::display {

SplatTargets::SplatTargets(const lpe::ProgramView& program, std::span<const ChannelId> channel_of_accept) : begin_{0} {
    for (lpe::State state = 0; state < program.state_count; ++state) {
        for (const std::uint16_t channel : program.accepted(state)) targets_.push_back(channel_of_accept[channel]);
        begin_.push_back(static_cast<std::uint32_t>(targets_.size()));
    }
}

SplatSets::SplatSets(const lpe::ProgramView& program, std::span<const ChannelId> channel_of_accept,
                     std::span<const std::uint8_t> shares, int block_size)
    : shared_(shares.size(), 0), block_bits_(std::countr_zero(static_cast<unsigned>(block_size))) {
    std::map<std::vector<ChannelId>, ChannelId> id_of;
    targets_.begin_ = {0};
    for (lpe::State state = 0; state < program.state_count; ++state) {
        std::vector<ChannelId> together;
        for (const std::uint16_t accepted : program.accepted(state)) {
            const ChannelId channel = channel_of_accept[accepted];
            (shares[static_cast<std::size_t>(channel)] != 0 ? together : targets_.targets_).push_back(channel);
        }
        if (!together.empty()) {
            std::sort(together.begin(), together.end());
            const auto [found, fresh] = id_of.emplace(std::move(together), ~static_cast<ChannelId>(id_of.size()));
            if (fresh) {
                channels_.insert(channels_.end(), found->first.begin(), found->first.end());
                begin_.push_back(static_cast<std::uint32_t>(channels_.size()));
            }
            targets_.targets_.push_back(found->second);
        }
        targets_.begin_.push_back(static_cast<std::uint32_t>(targets_.targets_.size()));
    }
    for (const ChannelId channel : channels_) shared_[static_cast<std::size_t>(channel)] = 1;
}

}  // namespace raylex::display
