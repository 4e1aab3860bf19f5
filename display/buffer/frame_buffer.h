// The frame buffer and its one canonical record.
//
// Canonical summation. The samples of a pixel are summed in double, in sample order, over aligned blocks of
// `block_size` samples; each block sum is then added exactly, in 128-bit fixed point with quantum 2^quantum_exponent.
// Integer addition is associative, so the sum does not depend on which thread, session or shard brought a block, nor in
// which order (Law 3). The quantum is 2^-80 by default: relative to a pixel of 1e-12 still below 1e-12 (Law 1), with room
// for sums up to 2^47. A block sum out of range is rejected and counted like a non-finite value, never wrapped.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "display/services/sample_table.h"

namespace raylex::display {

struct FrameBufferLayout {
    int width = 0, height = 0;
    int block_size = 16;          ///< samples per canonical block; a power of two
    int quantum_exponent = -80;
};

class FrameBuffer {
  public:
    FrameBuffer(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels);
    ~FrameBuffer();
    FrameBuffer(FrameBuffer&&) noexcept;
    FrameBuffer& operator=(FrameBuffer&&) noexcept;

    /// Takes in one batch: every run of rows of one pixel must be (part of) one aligned block, whole unless it is the last
    /// of the budget. Threads may call at once for different pixels.
    void accumulate(const SampleTable& table);

    [[nodiscard]] const FrameBufferLayout& layout() const;
    [[nodiscard]] std::span<const ChannelDefinition> channels() const;
    [[nodiscard]] std::uint64_t sample_count(int x, int y) const;
    [[nodiscard]] std::uint64_t rejected_count() const;   ///< block sums out of range

    /// The pixels of a channel, row-major from the top, components interleaved: filtered value, or what its rule picks.
    [[nodiscard]] std::vector<double> resolve(ChannelId id) const;
    /// Coverage: filtered mean of the samples' opacity.
    [[nodiscard]] std::vector<double> resolve_alpha() const;
    /// Variance of the pixel mean (sample variance / n) of a channel with `statistics`; importance mode only.
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(ChannelId id) const;

  private:
    struct Storage;
    std::unique_ptr<Storage> storage_;
};

}  // namespace raylex::display
