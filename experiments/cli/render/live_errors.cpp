#include "experiments/cli/render/live_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>

#include "experiments/program/console.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

constexpr int tile = 16;             // pixels; reading a tile locks it, so render threads that need it wait
constexpr std::uint64_t block = 16;  // samples that a pixel receives at once
constexpr std::uint64_t most_pixels = 1ULL << 15;  // enough to know an error to a few per cent of itself
constexpr double seconds_between = 1, share_of_time = 0.01;

/// Returns tiles spread over the rendered region: every `step`-th tile of a row, with an offset that differs from row
/// to row.
std::vector<display::PixelRegion> chosen_tiles(const display::PixelRegion& whole) {
    const std::uint64_t pixels = static_cast<std::uint64_t>(whole.width()) * static_cast<std::uint64_t>(whole.height());
    const int step = static_cast<int>((pixels + most_pixels - 1) / most_pixels);
    std::vector<display::PixelRegion> regions;
    for (int y = whole.y0, row = 0; y < whole.y1; y += tile, ++row)
        for (int x = whole.x0, column = 0; x < whole.x1; x += tile, ++column)
            if ((column + 3 * row) % step == 0)
                regions.push_back({x, y, std::min(x + tile, whole.x1), std::min(y + tile, whole.y1)});
    return regions;
}

/// Returns whether the channel has a relative error. That is so for light and colours, not for positions and depths.
bool has_error(const display::ChannelDefinition& channel) {
    const bool color = channel.style == display::ChannelStyle::expression || channel.type == display::ChannelType::rgb;
    return color && channel.statistics && display::takes_samples(channel);
}

std::string percent_text(double share, int digits) {
    const double percent = 100 * share;
    std::array<char, 32> text{};
    if (percent >= 10) std::snprintf(text.data(), text.size(), "%.0f", percent);
    else std::snprintf(text.data(), text.size(), "%.*g", digits, percent);
    return text.data();
}

}  // namespace

void LiveErrors::begin(const transport::RenderPlan& plan) {
    *this = LiveErrors();
    const auto add = [&](std::size_t i) {
        const display::ChannelDefinition& channel = plan.channels[i];
        if (has_error(channel))
            channels_.push_back({channel.name, static_cast<display::ChannelId>(i),
                                 static_cast<std::size_t>(display::component_count(channel.type))});
    };
    if (plan.beauty >= 0) add(static_cast<std::size_t>(plan.beauty));
    for (std::size_t i = 0; i < plan.channels.size(); ++i)
        if (static_cast<display::ChannelId>(i) != plan.beauty) add(i);
    measured_.resize(channels_.size());
    regions_ = chosen_tiles(plan.crop);
    pixels_ = static_cast<std::uint64_t>(plan.crop.width()) * static_cast<std::uint64_t>(plan.crop.height());
}

ChannelError LiveErrors::measure(const transport::LiveImage& image, std::size_t channel, std::uint64_t samples,
                                 display::ErrorForecast* forecast) const {
    const Channel& of = channels_[channel];
    std::vector<double> values, variances;
    for (const display::PixelRegion& region : regions_) {
        const std::vector<double> value = image.resolve(of.id, region);
        const std::vector<double> variance = image.resolve_variance_of_mean(of.id, region);
        values.insert(values.end(), value.begin(), value.end());
        variances.insert(variances.end(), variance.begin(), variance.end());
    }
    std::vector<display::PixelMoments> pixels = display::pixel_moments(values, variances, of.components);
    const double dark = display::darkest(pixels, display::AdaptiveSettings().floor);
    double sum = 0, squares = 0;
    for (display::PixelMoments& pixel : pixels) {
        pixel.samples = static_cast<double>(samples) / static_cast<double>(pixels_);
        const double each = display::relative_error(pixel, dark);
        sum += each * each;
        squares += each * each * each * each;
    }
    const auto n = static_cast<double>(pixels.size());
    if (forecast != nullptr) {
        std::span<const display::PixelMoments> left = pixels;
        for (const display::PixelRegion& region : regions_) {
            const auto count = static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height());
            forecast->add({left.first(count), region.width(), region.height(), dark});
            left = left.subspan(count);
        }
    }
    const double mean = sum / n, variance = n > 1 ? std::max(0.0, squares - n * mean * mean) / (n * (n - 1)) : 0;
    const double error = std::sqrt(mean);
    return {of.name, error, error > 0 ? std::sqrt(variance) / (2 * error) : 0};
}

void LiveErrors::update(const transport::RenderProgress& now) {
    if (channels_.empty() || now.image == nullptr || now.seconds < next_ || now.samples_done < block * pixels_) return;
    const double begin = transport::thread_cpu_seconds();
    display::ErrorForecast forecast;
    measured_.front() = measure(*now.image, 0, now.samples_done, &forecast);
    const std::size_t others = channels_.size() - 1;
    for (std::size_t i = 0; i < std::min(others, channels_at_once - 1); ++i, turn_ = (turn_ + 1) % others)
        measured_[1 + turn_] = measure(*now.image, 1 + turn_, now.samples_done, nullptr);
    errors_.clear();
    for (const std::optional<ChannelError>& each : measured_)
        if (each) errors_.push_back(*each);
    std::stable_sort(errors_.begin() + 1, errors_.end(),
                     [](const ChannelError& a, const ChannelError& b) { return a.error > b.error; });
    forecast_ = forecast;
    samples_ = now.samples_done;
    next_ = now.seconds + std::max(seconds_between, (transport::thread_cpu_seconds() - begin) / share_of_time);
}

display::Forecast LiveErrors::samples_to(double error) const {
    const auto pixels = static_cast<double>(pixels_);
    const display::Forecast samples = forecast_.samples_to(error);
    return {samples.expected * pixels, samples.least * pixels};
}

double LiveErrors::error_after(double samples) const {
    return forecast_.error_after(samples / static_cast<double>(pixels_));
}

std::optional<double> next_mark(double error) {
    for (const double mark : {0.10, 0.05, 0.02, 0.01, 0.005})
        if (mark < error) return mark;
    return std::nullopt;
}

std::string remaining_text(const transport::RenderProgress& now, const display::Forecast& samples) {
    const auto done = static_cast<double>(now.samples_done);
    // A bound that has already passed carries no information.
    const bool bound = samples.least > done;
    return (bound ? "at least " : "about ") +
           duration_text(now.seconds * ((bound ? samples.least : samples.expected) - done) / done);
}

std::string error_text(const LiveErrors& errors, const transport::RenderProgress& now, std::size_t channels) {
    const std::vector<ChannelError>& known = errors.errors();
    if (known.empty()) return {};
    const std::size_t shown = std::clamp<std::size_t>(channels, 1, known.size());
    std::string text;
    for (std::size_t i = 0; i < shown; ++i) {
        text += (i == 0 ? "" : ", ") + known[i].name + " " + percent_text(known[i].error, 2) + " %";
        // A smaller uncertainty is rounding.
        if (known[i].uncertainty > 1e-4 * known[i].error) text += " +- " + percent_text(known[i].uncertainty, 1);
    }
    if (const std::size_t more = known.size() - shown + errors.further(); more > 0)
        text += " and " + std::to_string(more) + " more";
    const auto done = static_cast<double>(now.samples_done), total = static_cast<double>(now.samples_total);
    const double first = known.front().error;
    if (done >= total || done == 0 || first == 0) return text;
    double target = 0;
    display::Forecast needed{total, static_cast<double>(now.samples_least)};
    if (now.adaptive != nullptr) {
        target = now.adaptive->target;  // the requested error, which also determines the predicted total
    } else if (const auto mark = next_mark(first)) {
        target = *mark;
        needed = errors.samples_to(target);
    }
    if (target == 0 || needed.expected > total)
        return text + "; " + percent_text(errors.error_after(total), 2) + " % at the end";
    if (needed.expected <= done) return text;
    return text + "; " + percent_text(target, 2) + " % in " + remaining_text(now, needed);
}

}  // namespace raylex::experiments
