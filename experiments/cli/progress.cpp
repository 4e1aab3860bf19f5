#include "experiments/cli/progress.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "experiments/cli/console.h"

namespace raylex::experiments {
namespace {

constexpr double seconds_between_lines = 5.0;

}  // namespace

Progress::Progress() : terminal_(error_stream_is_terminal()) {}

std::string Progress::describe(const transport::RenderProgress& progress, int width) {
    const double total = static_cast<double>(std::max<std::uint64_t>(progress.samples_total, 1));
    const double done = std::min(static_cast<double>(progress.samples_done) / total, 1.0);
    std::string text;
    if (width > 0) {
        const int filled = static_cast<int>(done * width);
        text = "[" + std::string(static_cast<std::size_t>(filled), '#') +
               std::string(static_cast<std::size_t>(width - filled), '.') + "] ";
    }
    std::array<char, 128> numbers{};
    const double rate =
        progress.seconds > 0 ? static_cast<double>(progress.samples_done) / progress.seconds * 1e-6 : 0.0;
    std::snprintf(numbers.data(), numbers.size(), "%3.0f %%  %.2f M samples/s  ", done * 100, rate);
    text += numbers.data();
    text += duration_text(progress.seconds);
    // Half a second of rendering says too little about the rest.
    const bool predicts = done < 1 && done > 0 && progress.seconds > 0.5;
    const std::string left = predicts ? "about " + duration_text(progress.seconds * (1 - done) / done) : std::string();
    if (progress.adaptive == nullptr) return predicts ? text + ", " + left + " left" : text;
    const display::AdaptiveProgress& adaptive = *progress.adaptive;
    if (adaptive.channel.empty()) return text + ", error not known yet";
    text += ", " + adaptive.channel + " " + number_text(100 * adaptive.error, 2) + " %";
    return predicts ? text + "; " + number_text(100 * adaptive.target, 2) + " % in " + left : text;
}

void Progress::update(const transport::RenderProgress& progress) {
    if (terminal_) {
        std::string text = describe(progress, 30);
        const std::size_t length = text.size();
        if (length < drawn_length_) text.append(drawn_length_ - length, ' ');
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
