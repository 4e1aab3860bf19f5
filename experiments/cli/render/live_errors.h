// What the errors of the channels are while they are being rendered, and when they will be small enough.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "transport/render/render.h"

namespace raylex::experiments {

/// `error` is AdaptiveProgress::error of the channel alone. `uncertainty` is its standard error, as the pixels' squares
/// scatter; they differ for other reasons too, so it is at least that.
struct ChannelError {
    std::string name;
    double error = 0, uncertainty = 0;
};

/// Looks at the image that there is, of a large one at some tiles all over it; no sample changes by that.
class LiveErrors {
  public:
    /// Channels that one update looks at: the beauty, and of the others the next ones in turn.
    static constexpr std::size_t channels_at_once = 4;

    /// The channels of light and colour that keep statistics.
    void begin(const transport::RenderPlan& plan);
    /// Measures once a second at most, and so that it takes at most a hundredth of one processor's time.
    void update(const transport::RenderProgress& now);

    /// As last measured: the beauty, then the others, the largest error first; empty until every pixel has a block of
    /// samples.
    [[nodiscard]] const std::vector<ChannelError>& errors() const { return errors_; }
    /// Camera samples of the image when that was measured.
    [[nodiscard]] std::uint64_t samples() const { return samples_; }
    /// Camera samples of the image until the beauty's error comes to that.
    [[nodiscard]] display::Forecast samples_to(double error) const;
    /// The beauty's error after so many camera samples of the image.
    [[nodiscard]] double error_after(double samples) const;
    /// Channels with statistics that have not been measured yet.
    [[nodiscard]] std::size_t further() const { return channels_.size() - errors_.size(); }

  private:
    /// With a forecast when there is one to fill.
    [[nodiscard]] ChannelError measure(const transport::LiveImage& image, std::size_t channel, std::uint64_t samples,
                                       display::ErrorForecast* forecast) const;
    struct Channel {
        std::string name;
        display::ChannelId id;
        std::size_t components;
    };
    std::vector<Channel> channels_;
    std::vector<display::PixelRegion> regions_;
    std::uint64_t pixels_ = 0, samples_ = 0;
    std::size_t turn_ = 0;  // of the channels behind the first, the one to be measured next
    std::vector<std::optional<ChannelError>> measured_;  // beside channels_
    double next_ = 0;
    std::vector<ChannelError> errors_;
    display::ErrorForecast forecast_;  // of the first channel, by samples of a pixel
};

/// The largest of 10, 5, 2, 1 and 0.5 % that is still below an error.
std::optional<double> next_mark(double error);

/// "about 2 min 40 s" until so many samples are done, or "at least 2 min" where few pixels decide when that is.
std::string remaining_text(const transport::RenderProgress& now, const display::Forecast& samples);

/// "beauty 2.3 % +- 0.1, caustics 11 % +- 2 and 3 more; 1 % in about 2 min 40 s": at most `channels` of them, and when
/// the beauty's error comes to what was asked for, else to the next mark, or what it is in the end when that comes
/// first. Empty while nothing is known.
std::string error_text(const LiveErrors& errors, const transport::RenderProgress& now, std::size_t channels);

}  // namespace raylex::experiments
