#include "experiments/cli/render/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cstdio>

#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

constexpr double seconds_between_lines = 5.0;
constexpr int bar_width = 30;

/// Returns the width in columns of the terminal on standard error; 0 if unknown.
std::size_t columns() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

}  // namespace

Progress::Progress() : terminal_(error_stream_is_terminal()) {}

void Progress::begin(const transport::RenderPlan& plan) {
    if (terminal_) errors_.begin(plan);
}

std::string Progress::describe(const transport::RenderProgress& progress, int bar, const LiveErrors& errors,
                               std::size_t channels) {
    const double total = static_cast<double>(std::max<std::uint64_t>(progress.samples_total, 1));
    const double done = std::min(static_cast<double>(progress.samples_done) / total, 1.0);
    std::string text;
    if (bar > 0) {
        const int filled = static_cast<int>(done * bar);
        text = "[" + std::string(static_cast<std::size_t>(filled), '#') +
               std::string(static_cast<std::size_t>(bar - filled), '.') + "] ";
    }
    std::array<char, 128> numbers{};
    const double rate =
        progress.seconds > 0 ? static_cast<double>(progress.samples_done) / progress.seconds * 1e-6 : 0.0;
    std::snprintf(numbers.data(), numbers.size(), "%3.0f %%  %.2f M samples/s  ", done * 100, rate);
    text += numbers.data();
    text += duration_text(progress.seconds);
    // Half a second of rendering is too short for a prediction.
    const bool predicts = done < 1 && done > 0 && progress.seconds > 0.5;
    const std::string left = predicts ? "about " + duration_text(progress.seconds * (1 - done) / done) : std::string();
    const std::string measured = error_text(errors, progress, channels);
    if (progress.adaptive == nullptr) {
        if (predicts) text += ", " + left + " left";
        return measured.empty() ? text : text + "; " + measured;
    }
    if (!measured.empty()) return text + ", " + measured;
    const display::AdaptiveProgress& adaptive = *progress.adaptive;
    if (adaptive.channel.empty()) return text + ", error unknown yet";
    text += ", " + adaptive.channel + " " + number_text(100 * adaptive.error, 2) + " %";
    if (!predicts) return text;
    const display::Forecast samples{total, static_cast<double>(progress.samples_least)};
    return text + "; " + number_text(100 * adaptive.target, 2) + " % in " + remaining_text(progress, samples);
}

std::string Progress::line(const transport::RenderProgress& progress) const {
    const std::size_t room = columns();
    // The cursor stands after the text, so a text as wide as the terminal would begin another line.
    const auto fits = [room](const std::string& text) { return room == 0 || text.size() < room; };
    std::string text = describe(progress, bar_width, errors_);
    for (std::size_t channels = std::max<std::size_t>(errors_.errors().size(), 1); !fits(text) && channels > 0;
         --channels)
        text = describe(progress, 0, errors_, channels);
    if (!fits(text)) text.resize(room - 1);
    return text;
}

void Progress::update(const transport::RenderProgress& progress) {
    if (terminal_) {
        errors_.update(progress);
        std::string text = line(progress);
        const std::size_t length = text.size();
        if (length < drawn_length_) text.append(drawn_length_ - length, ' ');  // blanks erase the longer text before
        drawn_length_ = length;
        std::fprintf(stderr, "\r%s", text.c_str());
        std::fflush(stderr);
        drawn_ = true;
    } else if (progress.seconds - last_line_ >= seconds_between_lines) {
        last_line_ = progress.seconds;
        std::fprintf(stderr, "rendering %s\n", describe(progress, 0).c_str());
    }
}

void Progress::finish() {
    if (drawn_) std::fputc('\n', stderr);
    drawn_ = false;
}

}  // namespace raylex::experiments
