// How many samples a render gets that ends by a clock or by its error: the arithmetic of LimitedSchedule. What may be
// asked for is SampleLimit (render.h).
//
// The render goes in passes over the whole image, each of whole blocks but the last. Between two passes nothing is in
// flight, so the frame buffer and the clock say together what the next pass is: an eighth of what there is (as adaptive
// sampling does), or less where the limit is nearer.
#pragma once

#include <cstdint>
#include <optional>

#include "transport/render/render.h"

namespace raylex::transport {

/// Most samples per pixel of a render that ends by itself and was given no number.
inline constexpr std::uint64_t most_limited_samples = (std::uint64_t{1} << 31) - 1;

class LimitedPasses {
  public:
    /// `block` samples are one step; `single` passes never have more than one. `layout` and `channels` are the frame
    /// buffer's.
    LimitedPasses(const SampleLimit& limit, std::uint64_t most, std::uint64_t block, bool single,
                  std::span<const display::ChannelDefinition> channels, display::ChannelId beauty,
                  const display::FrameBufferLayout& layout);

    /// Every pixel has `done` samples, and the render has taken `seconds`. Returns how many it has after the next pass;
    /// `done` when it is over. The first call of a session starts its clock.
    std::uint64_t next_end(std::uint64_t done, double seconds, const display::FrameBuffer& buffer);

    /// Of the whole image, when `done` camera samples took `seconds`; `done` while nothing can be said.
    [[nodiscard]] display::Forecast predicted(std::uint64_t done, double seconds) const;
    /// Null when the limit is none of error.
    [[nodiscard]] const display::AdaptiveProgress* error() const { return error_ ? &error_->progress() : nullptr; }

  private:
    [[nodiscard]] std::uint64_t within_error(std::uint64_t done, std::uint64_t end, const display::FrameBuffer& buffer);
    [[nodiscard]] std::uint64_t within_time(std::uint64_t done, std::uint64_t end, double seconds) const;

    SampleLimit limit_;
    std::uint64_t most_, block_, pixels_;
    bool single_;
    std::optional<display::AdaptiveSampler> error_;  // measures alone: what it would open is not asked
    bool started_ = false;
    std::uint64_t first_ = 0;  // samples and seconds when the session began
    double first_seconds_ = 0;
};

}  // namespace raylex::transport
