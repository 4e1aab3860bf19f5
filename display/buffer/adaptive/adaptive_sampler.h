// Which pixels need more samples: decided between rounds of samples, from the frame buffer's own sums and nothing else,
// so that a render takes the same decisions on any number of threads and after any interruption (Law 3).
//
// For a channel of the metric with weight g, the error of a pixel is its standard error relative to its value:
//
//     e = g s / max(m, f M)
//
// s^2 is the variance of the pixel's mean (FrameBuffer::resolve_variance_of_mean), averaged over the components; m the
// mean of the components' absolute values, M the mean of m over the image, and f the floor: where a pixel is darker
// than f M, what counts is the error relative to f M, so that black pixels end. Where M is 0 the error is 0. A pixel's
// error is the largest of its channels'. It goes on while the largest error in its neighbourhood (a square of 2 r + 1
// pixels) is above the tolerance; before `min_samples` always, from `max_samples` on never. A pixel that stopped goes
// on again when a neighbour finds that it should.
//
// Samples decide about samples, so a mean that was found adaptively is biased, and low: a pixel that has missed its
// rare bright samples so far looks finished. The neighbourhood is there because it lowers that bias, by about what
// tests/transport/render/adaptive_test.cpp measures; display/README.md states it.
//
// s^2 takes samples as independent. Sobol' points vary less, so for them the error is overestimated.
//
// How many samples a pixel takes in all is predicted from pools of pixels (error_forecast.h): it goes on until the
// largest error of its neighbourhood, by their E, comes down to the tolerance. In larger and larger pools ever fewer of
// its neighbours have an error of their own; so the largest is taken to be at least what the largest of so many normal
// numbers is (Tippett, Biometrika 17, 1925) that scatter by the pool's own deviation. Predictions decide nothing.
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
    std::uint64_t min_samples = 64;         ///< of a pixel; rounded up to whole blocks
    std::uint64_t max_samples = 65536;
    double floor = 0.1;     ///< f above, from 0
    int neighbourhood = 1;  ///< r above, 0 to 8
    SourceLocation location{};
};

/// How far an adaptive render is.
struct AdaptiveProgress {
    std::string channel;            ///< of the metric, the one with the largest error; empty before the first decision
    double error = 0;               ///< its error, as the root of the mean square over pixels
    double target = 0;              ///< AdaptiveSettings::error
    std::uint64_t open_pixels = 0;  ///< that go on
    std::uint64_t predicted_samples = 0;  ///< of the whole image in the end
    std::uint64_t least_samples = 0;      ///< Forecast::least of that; 0 until the first decision after a resume
};

class AdaptiveSampler {
  public:
    /// Errors: settings out of range, channels that are not there (with the near miss) or keep no statistics (rules,
    /// integers). `beauty` may be invalid_channel when channels are named.
    static Status check(const AdaptiveSettings& settings, std::span<const ChannelDefinition> channels,
                        ChannelId beauty);
    /// After check(). All pixels are open.
    AdaptiveSampler(const AdaptiveSettings& settings, std::span<const ChannelDefinition> channels, ChannelId beauty,
                    const FrameBufferLayout& layout);

    /// Looks at the frame buffer and decides anew for every pixel. Not while samples are being added.
    void decide(const FrameBuffer& buffer);
    [[nodiscard]] bool open(int x, int y) const { return open_[index(x, y)] != 0; }
    [[nodiscard]] bool done() const { return progress_.open_pixels == 0; }
    /// Blocks that every open pixel gets before the next decision. They grow with what there is, by an eighth: then a
    /// render decides seldom, and does at most an eighth too much.
    [[nodiscard]] std::uint64_t blocks() const { return blocks_; }
    [[nodiscard]] std::uint64_t max_samples() const { return settings_.max_samples; }
    [[nodiscard]] const AdaptiveProgress& progress() const { return progress_; }
    /// How AdaptiveProgress::error goes on when all pixels get as many samples; empty before the first decision.
    [[nodiscard]] const ErrorForecast& forecast() const { return forecast_; }
    /// Pixels whose own error was above the tolerance at the last decision, although they are not open.
    [[nodiscard]] std::uint64_t unconverged() const;
    /// Each pixel's error after the last decision, before the neighbourhood; empty before the first.
    [[nodiscard]] std::span<const double> errors() const { return errors_; }

    /// What decide() last decided, as bytes: for a checkpoint amid a round, when the frame buffer is past the decision.
    void append_record(std::string& bytes) const;
    Status restore_record(std::string_view bytes);

  private:
    [[nodiscard]] std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(layout_.width) + static_cast<std::size_t>(x);
    }
    /// Returns them as PooledErrors.
    PooledErrors add_errors(const FrameBuffer& buffer, ChannelId id, double weight, double& mean_square);
    /// `largest`: errors_ spread; `pools`: [settings_.channels], `worst` that of progress_.channel.
    void predict(const FrameBuffer& buffer, const std::vector<double>& largest, std::vector<PooledErrors>& pools,
                 std::size_t worst);
    /// The largest value within the neighbourhood, for every pixel.
    [[nodiscard]] std::vector<double> spread(const std::vector<double>& values) const;

    AdaptiveSettings settings_;
    FrameBufferLayout layout_;
    std::vector<ChannelId> ids_;            // [settings_.channels]
    std::vector<double> errors_;            // [pixel]
    std::vector<std::uint8_t> open_;        // [pixel]
    std::uint64_t blocks_ = 1, taken_ = 0;  // taken_: blocks of an always open pixel before this round
    AdaptiveProgress progress_;
    ErrorForecast forecast_;
};

/// One line for headers and records: what the decisions depend on.
std::string describe(const AdaptiveSettings& settings);

}  // namespace raylex::display
