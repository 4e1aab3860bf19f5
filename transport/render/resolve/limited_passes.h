// The number of samples of a render that ends by time or error: the arithmetic of LimitedSchedule. SampleLimit
// (render.h) contains the limits.
//
// The render makes passes over the whole image, each of whole blocks except the last. Between two passes no samples are
// in progress, so the frame buffer and the clock determine the next pass: an eighth of the samples so far (as in
// adaptive sampling), or less if the limit is nearer.
#pragma once

#include <cstdint>
#include <optional>

#include "transport/render/render.h"

namespace raylex::transport {

/// Most samples per pixel of a render that ends by a limit and has no number of samples.
inline constexpr std::uint64_t most_limited_samples = (std::uint64_t{1} << 31) - 1;

/// Fewer samples per pixel do not estimate their own error well enough to stop by it.
inline constexpr std::uint64_t least_for_error = 64;

class LimitedPasses {
  public:
    /// `block` samples are one step; with `single`, passes have at most one. `layout` and `channels` are those of the
    /// frame buffer.
    LimitedPasses(const SampleLimit& limit, std::uint64_t most, std::uint64_t block, bool single,
                  std::span<const display::ChannelDefinition> channels, display::ChannelId beauty,
                  const display::FrameBufferLayout& layout);

    /// Every pixel has `done` samples, and the render has taken `seconds`. Returns the number after the next pass, or
    /// `done` if the render is over. The first call of a session starts its clock.
    std::uint64_t next_end(std::uint64_t done, double seconds, const display::FrameBuffer& buffer);

    /// The forecast for the whole image, when `done` camera samples took `seconds`; `done` if nothing can be predicted
    /// yet.
    [[nodiscard]] display::Forecast predicted(std::uint64_t done, double seconds) const;
    /// Null if there is no limit of error.
    [[nodiscard]] const display::AdaptiveProgress* error() const { return error_ ? &error_->progress() : nullptr; }

  private:
    [[nodiscard]] std::uint64_t within_error(std::uint64_t done, std::uint64_t end, const display::FrameBuffer& buffer);
    [[nodiscard]] std::uint64_t within_time(std::uint64_t done, std::uint64_t end, double seconds) const;

    SampleLimit limit_;
    std::uint64_t most_, block_, pixels_;
    bool single_;
    std::optional<display::AdaptiveSampler> error_;  // used for measuring only, not for choosing pixels
    bool started_ = false;
    std::uint64_t first_ = 0;  // samples and seconds at the beginning of the session
    double first_seconds_ = 0;
};

}  // namespace raylex::transport
