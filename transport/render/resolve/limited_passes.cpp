#include "transport/render/resolve/limited_passes.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

display::AdaptiveSettings measure_of(double error, std::uint64_t most) {
    display::AdaptiveSettings settings;
    settings.error = error;
    settings.neighbourhood = 0;
    settings.max_samples = most;
    settings.min_samples = std::min(settings.min_samples, most);
    return settings;
}

}  // namespace

LimitedPasses::LimitedPasses(const SampleLimit& limit, std::uint64_t most, std::uint64_t block, bool single,
                             std::span<const display::ChannelDefinition> channels, display::ChannelId beauty,
                             const display::FrameBufferLayout& layout)
    : limit_(limit),
      most_(most),
      block_(block),
      pixels_(static_cast<std::uint64_t>(layout.width) * static_cast<std::uint64_t>(layout.height)),
      single_(single) {
    if (limit.error > 0) error_.emplace(measure_of(limit.error, most), channels, beauty, layout);
}

std::uint64_t LimitedPasses::next_end(std::uint64_t done, double seconds, const display::FrameBuffer& buffer) {
    if (!started_) {
        started_ = true;
        first_ = done;
        first_seconds_ = seconds;
    }
    if (done >= most_ || done % block_ != 0) return done;
    const std::uint64_t blocks = single_ ? 1 : std::max<std::uint64_t>(1, done / block_ / 8);
    std::uint64_t end = std::min(done + blocks * block_, most_);
    if (error_) end = within_error(done, end, buffer);
    if (limit_.seconds > 0) end = within_time(done, end, seconds);
    return end;
}

std::uint64_t LimitedPasses::within_error(std::uint64_t done, std::uint64_t end, const display::FrameBuffer& buffer) {
    if (done < std::min(least_for_error, most_)) return end;
    error_->decide(buffer);
    const double error = error_->progress().error;
    if (error <= limit_.error) return done;
    // As many samples as needed, but at least one block.
    const double wanted = display::samples_to_error(static_cast<double>(done), error, limit_.error);
    if (wanted >= static_cast<double>(end)) return end;
    const auto blocks =
        static_cast<std::uint64_t>(std::ceil((wanted - static_cast<double>(done)) / static_cast<double>(block_)));
    return std::min(done + std::max<std::uint64_t>(1, blocks) * block_, end);
}

std::uint64_t LimitedPasses::within_time(std::uint64_t done, std::uint64_t end, double seconds) const {
    const double rate =
        done > first_ ? (seconds - first_seconds_) / static_cast<double>(done - first_) : limit_.seconds_per_sample;
    const double left = limit_.seconds - seconds;
    if (rate > 0) {
        // The time per sample varies, and a pass that ends late may be discarded. While much time is left, a twentieth
        // of it is reserved for that; later passes use it.
        const double planned = left > 4 ? 0.95 * left : left;
        const double most = std::floor(std::max(planned, 0.0) / rate);
        if (most < static_cast<double>(end - done)) end = done + static_cast<std::uint64_t>(most);
        // Only the last pass may end within a block.
        if (end - done > block_) end -= (end - done) % block_;
    } else if (left <= 0) {
        end = done;
    }
    return done == 0 ? std::max<std::uint64_t>(end, 1) : end;
}

display::Forecast LimitedPasses::predicted(std::uint64_t done, double seconds) const {
    const auto samples = static_cast<double>(done), pixels = static_cast<double>(pixels_);
    double total = static_cast<double>(most_) * pixels, least = 0;
    if (limit_.seconds > 0 && seconds > 0) total = std::min(total, samples * limit_.seconds / seconds);
    if (error_ && !error_->forecast().empty()) {
        const display::Forecast forecast = error_->forecast().samples_to(limit_.error);
        least = forecast.least * pixels;
        total = std::min(total, forecast.expected * pixels);
    } else if (error_ && limit_.seconds <= 0) {
        total = samples;
    }
    return {std::max(samples, total), least < total ? least : 0};
}

}  // namespace raylex::transport
