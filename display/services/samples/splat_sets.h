// Where contributions go: by the automaton's state, what of the sample table takes them.
//
// Of many channels a path usually reaches the same few together, so lists of channels repeat. A channel whose samples
// nobody looks at one by one need not get them one by one: the list has a sum for each block of samples, to which a
// contribution is added once, and the frame buffer hands those on. What asking for a channel costs then hardly depends
// on how many other channels take the same light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "lpe/program_view.h"

namespace raylex::display {

/// [table state of the program] what takes a contribution that ends there: channels by their id, and sets by the
/// complement of theirs, which is negative.
class SplatTargets {
  public:
    SplatTargets() = default;
    /// Each channel by itself: `channel_of_accept` are the program's channels.
    SplatTargets(const lpe::ProgramView& program, std::span<const ChannelId> channel_of_accept);

    [[nodiscard]] std::span<const ChannelId> of(lpe::State state) const {
        return {targets_.data() + begin_[state], targets_.data() + begin_[state + 1]};
    }

  private:
    friend class SplatSets;
    std::vector<std::uint32_t> begin_;  // [state + 1] into targets_
    std::vector<ChannelId> targets_;
};

/// Every list of channels that some path can end in. Immutable, of all threads. There are many more than a batch of
/// samples needs: a SampleTable gives those that come up a place, in the order of their coming.
class SplatSets {
  public:
    /// `shares` [channel] says which channels may go without samples of their own; the others stay by themselves.
    /// `block_size` is the frame buffer's.
    SplatSets(const lpe::ProgramView& program, std::span<const ChannelId> channel_of_accept,
              std::span<const std::uint8_t> shares, int block_size);

    [[nodiscard]] const SplatTargets& targets() const { return targets_; }
    [[nodiscard]] std::size_t size() const { return begin_.size() - 1; }
    [[nodiscard]] std::span<const ChannelId> channels_of(std::size_t set) const {
        return {channels_.data() + begin_[set], channels_.data() + begin_[set + 1]};
    }
    /// Samples of one pixel have a sum in common where their indices agree but for so many low bits.
    [[nodiscard]] int block_bits() const { return block_bits_; }
    /// [channel] whether sets stand for it.
    [[nodiscard]] std::span<const std::uint8_t> shared() const { return shared_; }

  private:
    SplatTargets targets_;
    std::vector<std::uint32_t> begin_{0};  // [set + 1] into channels_
    std::vector<ChannelId> channels_;
    std::vector<std::uint8_t> shared_;
    int block_bits_ = 0;
};

}  // namespace raylex::display
