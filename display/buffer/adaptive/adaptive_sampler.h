// Decides which pixels need more samples. It decides between rounds, and only from the sums in the frame buffer, so the
// decisions do not depend on threads or interruptions (Law 3).
//
// For a channel of the metric with weight g, the error of a pixel is its standard error relative to its value:
//
//     e = g s / max(m, f M)
//
// s^2 is the variance of the pixel's mean (FrameBuffer::resolve_variance_of_mean), averaged over the components. m is
// the mean of the components' absolute values, M the mean of m over the image, and f the floor: in a pixel darker than
// f M the error is relative to f M, so that black pixels converge. If M is 0, the error is 0. A pixel's error is the
// maximum over its channels. A pixel gets more samples while the largest error in its neighbourhood (a square of 2 r +
// 1 pixels) exceeds the tolerance; always before `min_samples`, never from `max_samples` on. A stopped pixel continues
// when the error of a neighbour rises above the tolerance.
//
// Adaptive stopping uses the same samples as the mean, so the mean is biased low: a pixel whose samples missed rare
// bright paths looks converged. The neighbourhood reduces this bias; tests/transport/render/adaptive_test.cpp measures
// by how much, and display/README.md states it.
//
// s^2 assumes independent samples. Sobol' points vary less, so for them the error is overestimated.
//
// Pools of pixels (error_forecast.h) predict the total number of samples of a pixel: the number at which the largest
// error in its neighbourhood, computed from the pools' E, reaches the tolerance. Larger pools leave fewer distinct
// errors in a neighbourhood. So the maximum is taken to be at least the expected maximum of that many normal numbers
// (Tippett, Biometrika 17, 1925) with the pool's own deviation. Predictions affect no decision.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/adaptive/error_forecast.h"
#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/parameters.h"

namespace raylex::display {

struct AdaptiveChannel {
    std::string name;
    double weight = 1;  ///< above 0; 2 halves the channel's tolerance
    SourceLocation location{};
};

struct AdaptiveSettings {
    double error = 0.01;                    ///< tolerance, above 0
    std::vector<AdaptiveChannel> channels;  ///< light or kernel-filtered; empty: beauty, or all light
    std::uint64_t min_samples = 64;         ///< per pixel; rounded up to whole blocks
    std::uint64_t max_samples = 65536;
    double floor = 0.1;     ///< f above, at least 0
    int neighbourhood = 1;  ///< r above, 0 to 8
    SourceLocation location{};
};

/// The progress of an adaptive render.
struct AdaptiveProgress {
    std::string channel;            ///< channel of the metric with the largest error; empty before the first decision
    double error = 0;               ///< its error: root of the mean square over pixels
    double target = 0;              ///< AdaptiveSettings::error
    std::uint64_t open_pixels = 0;  ///< pixels that need more samples
    std::uint64_t predicted_samples = 0;  ///< predicted total for the image
    std::uint64_t least_samples = 0;      ///< Forecast::least of that total; 0 until the first decision after a resume
};

class AdaptiveSampler {
  public:
    /// Checks the settings. Errors: settings out of range; channels that do not exist (the error suggests a similar
    /// name) or keep no statistics (rules, integers). `beauty` can be invalid_channel when channels are named.
    static Status check(const AdaptiveSettings& settings, std::span<const ChannelDefinition> channels,
                        ChannelId beauty);
    /// Requires a successful check(). All pixels start open.
    AdaptiveSampler(const AdaptiveSettings& settings, std::span<const ChannelDefinition> channels, ChannelId beauty,
                    const FrameBufferLayout& layout);

    /// Decides for every pixel, from the current frame buffer. Do not call it while samples are being added.
    void decide(const FrameBuffer& buffer);
    [[nodiscard]] bool open(int x, int y) const { return open_[index(x, y)] != 0; }
    [[nodiscard]] bool done() const { return progress_.open_pixels == 0; }
    /// The number of blocks that every open pixel gets before the next decision: an eighth of its samples. So decisions
    /// are rare, and at most an eighth of the samples is unnecessary.
    [[nodiscard]] std::uint64_t blocks() const { return blocks_; }
    [[nodiscard]] std::uint64_t max_samples() const { return settings_.max_samples; }
    [[nodiscard]] const AdaptiveProgress& progress() const { return progress_; }
    /// Predicts AdaptiveProgress::error if all pixels get the same number of samples; empty before the first decision.
    [[nodiscard]] const ErrorForecast& forecast() const { return forecast_; }
    /// Number of pixels that are not open although their own error exceeded the tolerance at the last decision.
    [[nodiscard]] std::uint64_t unconverged() const;
    /// Each pixel's own error at the last decision, without its neighbourhood; empty before the first decision.
    [[nodiscard]] std::span<const double> errors() const { return errors_; }

    /// Appends the last decision as bytes, for a checkpoint in the middle of a round, when the frame buffer has changed
    /// since.
    void append_record(std::string& bytes) const;
    Status restore_record(std::string_view bytes);

  private:
    [[nodiscard]] std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(layout_.width) + static_cast<std::size_t>(x);
    }
    /// Computes the errors of one channel, and returns its pixels as PooledErrors.
    PooledErrors add_errors(const FrameBuffer& buffer, ChannelId id, double weight, double& mean_square);
    /// `largest`: errors_ after spread(); `pools`: [settings_.channels]; `worst`: index of progress_.channel.
    void predict(const FrameBuffer& buffer, const std::vector<double>& largest, std::vector<PooledErrors>& pools,
                 std::size_t worst);
    /// The maximum over the neighbourhood of every pixel.
    [[nodiscard]] std::vector<double> spread(const std::vector<double>& values) const;

    AdaptiveSettings settings_;
    FrameBufferLayout layout_;
    std::vector<ChannelId> ids_;            // [settings_.channels]
    std::vector<double> errors_;            // [pixel]
    std::vector<std::uint8_t> open_;        // [pixel]
    std::uint64_t blocks_ = 1, taken_ = 0;  // taken_: blocks that an always open pixel had before this round
    AdaptiveProgress progress_;
    ErrorForecast forecast_;
};

/// One line for headers and records with all settings that affect decisions.
std::string describe(const AdaptiveSettings& settings);

}  // namespace raylex::display
