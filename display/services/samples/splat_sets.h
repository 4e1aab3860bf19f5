// The targets of contributions in the sample table, by the state of the automaton.
//
// A path usually reaches the same few of many channels together, so lists of channels repeat. A channel whose single
// samples are not needed can do without them: each list has a sum per block of samples, to which a contribution is
// added once, and the frame buffer distributes these sums. The cost of a channel then hardly depends on the number of
// channels that take the same light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "lpe/program_view.h"

namespace raylex::display {

/// [table state of the program] the targets of a contribution that ends there: channels by id, and sets by the
/// complement of their index, which is negative.
class SplatTargets {
  public:
    SplatTargets() = default;
    /// Each channel separately: `channel_of_accept` are the program's channels.
    SplatTargets(const lpe::ProgramView& program, std::span<const ChannelId> channel_of_accept);

    [[nodiscard]] std::span<const ChannelId> of(lpe::State state) const {
        return {targets_.data() + begin_[state], targets_.data() + begin_[state + 1]};
    }

  private:
    friend class SplatSets;
    std::vector<std::uint32_t> begin_;  // [state + 1] offset into targets_
    std::vector<ChannelId> targets_;
};

/// Every list of channels in which some path can end. Immutable, shared by all threads. There are many more than a
/// batch needs, so a SampleTable gives places to those that occur, in order of occurrence.
class SplatSets {
  public:
    /// `shares` [channel] marks the channels that can do without samples of their own; the others are separate targets.
    /// `block_size` is the frame buffer's.
    SplatSets(const lpe::ProgramView& program, std::span<const ChannelId> channel_of_accept,
              std::span<const std::uint8_t> shares, int block_size);

    [[nodiscard]] const SplatTargets& targets() const { return targets_; }
    [[nodiscard]] std::size_t size() const { return begin_.size() - 1; }
    [[nodiscard]] std::span<const ChannelId> channels_of(std::size_t set) const {
        return {channels_.data() + begin_[set], channels_.data() + begin_[set + 1]};
    }
    /// The number of low bits in which the indices of samples with a common sum may differ.
    [[nodiscard]] int block_bits() const { return block_bits_; }
    /// [channel] 1 if sets represent it.
    [[nodiscard]] std::span<const std::uint8_t> shared() const { return shared_; }

  private:
    SplatTargets targets_;
    std::vector<std::uint32_t> begin_{0};  // [set + 1] offset into channels_
    std::vector<ChannelId> channels_;
    std::vector<std::uint8_t> shared_;
    int block_bits_ = 0;
};

}  // namespace raylex::display
