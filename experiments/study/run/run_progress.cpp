#include "experiments/study/run/run_progress.h"

#include <cstdio>
#include <utility>

#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

constexpr double seconds_between_lines = 5.0;

}  // namespace

std::string time_left_text(double seconds, std::size_t unknown) {
    if (seconds < 0) return "unknown";
    return (unknown > 0 ? "at least " : "about ") + duration_text(seconds);
}

RunProgress::RunProgress(bool quiet) : quiet_(quiet), terminal_(error_stream_is_terminal()) {}

void RunProgress::begin(std::string title, double seconds_left, std::size_t unknown) {
    title_ = std::move(title);
    seconds_left_ = seconds_left;
    unknown_ = unknown;
    last_ = 0;
    if (terminal_) update({});
}

void RunProgress::update(const WorkProgress& now) {
    if (quiet_ || (!terminal_ && now.seconds - last_ < seconds_between_lines)) return;
    last_ = now.seconds;
    std::string text = title_ + "  " + number_text(100 * now.share, 2) + " %, " + duration_text(now.seconds);
    // Half a second of rendering is too short for a prediction.
    const bool predicts = now.share > 0 && now.share < 1 && now.seconds > 0.5;
    const double own = predicts ? now.seconds * (1 - now.share) / now.share : 0;
    if (now.error >= 0) text += ", error " + number_text(100 * now.error, 2) + " %";
    if (predicts) text += ", about " + duration_text(own) + " left";
    if (seconds_left_ >= 0) text += "; all: " + time_left_text(seconds_left_ + own, unknown_) + " left";
    if (!terminal_) {
        std::fprintf(stderr, "%s\n", text.c_str());
        return;
    }
    const std::size_t length = text.size();
    if (length < drawn_) text.append(drawn_ - length, ' ');
    drawn_ = length;
    std::fprintf(stderr, "\r%s", text.c_str());
    std::fflush(stderr);
}

void RunProgress::clear() {
    if (drawn_ > 0) std::fprintf(stderr, "\r%s\r", std::string(drawn_, ' ').c_str());
    drawn_ = 0;
}

void RunProgress::line(const std::string& text) {
    if (quiet_) return;
    clear();
    print_line(text);
    std::fflush(stdout);
}

}  // namespace raylex::experiments
