// Errors of the channels during a render, and forecasts of when they will be small enough.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "transport/render/render.h"

namespace raylex::experiments {

/// The error of one channel. `error` is a relative error as in AdaptiveProgress::error. `uncertainty` is its standard
/// error, estimated from the spread of the squared errors over pixels; since pixels differ for other reasons too, this
/// is an upper bound.
struct ChannelError {
    std::string name;
    double error = 0, uncertainty = 0;
};

/// Measures the errors of the unfinished image, from a spread of tiles if the image is large. It never changes a
/// sample.
class LiveErrors {
  public:
    /// Number of channels that one update measures: the beauty, and three of the others in turn.
    static constexpr std::size_t channels_at_once = 4;

    /// Chooses the channels: those of light and colour that keep statistics.
    void begin(const transport::RenderPlan& plan);
    /// Measures at most once a second, using at most a hundredth of one processor's time.
    void update(const transport::RenderProgress& now);

    /// The last measurements: the beauty first, then the others by decreasing error; empty until every pixel has a
    /// block of samples.
    [[nodiscard]] const std::vector<ChannelError>& errors() const { return errors_; }
    /// Number of camera samples of the whole image at the last measurement.
    [[nodiscard]] std::uint64_t samples() const { return samples_; }
    /// Forecast of the number of camera samples of the whole image at which the beauty's error reaches `error`.
    [[nodiscard]] display::Forecast samples_to(double error) const;
    /// Forecast of the beauty's error after `samples` camera samples of the whole image.
    [[nodiscard]] double error_after(double samples) const;
    /// Number of channels with statistics that have not been measured yet.
    [[nodiscard]] std::size_t further() const { return channels_.size() - errors_.size(); }

  private:
    /// Measures one channel. Also fills `forecast` unless it is null.
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
    std::size_t turn_ = 0;                               // index, after the first channel, of the next one to measure
    std::vector<std::optional<ChannelError>> measured_;  // parallel to channels_
    double next_ = 0;
    std::vector<ChannelError> errors_;
    display::ErrorForecast forecast_;  // of the first channel, by samples per pixel
};

/// Returns the largest of 10, 5, 2, 1 and 0.5 % that is below `error`.
std::optional<double> next_mark(double error);

/// Returns the time until `samples` camera samples are done: "about 2 min 40 s", or "at least 2 min" if few pixels
/// determine the forecast.
std::string remaining_text(const transport::RenderProgress& now, const display::Forecast& samples);

/// Returns the errors of at most `channels` channels and a forecast for the beauty: "beauty 2.3 % +- 0.1, caustics 11 %
/// +- 2 and 3 more; 1 % in about 2 min 40 s". The forecast is the time to the requested error, else to the next mark;
/// if the render ends before, it is the error at the end. Empty while nothing has been measured.
std::string error_text(const LiveErrors& errors, const transport::RenderProgress& now, std::size_t channels);

}  // namespace raylex::experiments
