#include "experiments/cli/loading_line.h"

#include <chrono>
#include <cstdio>

#include "display/services/thread_or_none.h"
#include "experiments/program/console.h"

namespace raylex::experiments {

LoadingLine::LoadingLine()
    : terminal_(error_stream_is_terminal()), thread_(display::thread_or_none([this] { watch(); })) {}

std::string LoadingLine::describe(const transport::LoadingProgress& progress, double seconds) {
    const std::uint64_t total = progress.total();
    std::string text = std::string("loading ") + progress.what();
    if (total > 0) text += ": " + std::to_string(progress.done()) + " of " + std::to_string(total);
    return text + ", " + duration_text(seconds);
}

void LoadingLine::watch() {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begin = Clock::now();
    const auto between = terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000);
    std::chrono::milliseconds next = terminal_ ? std::chrono::milliseconds(1000) : between;
    std::size_t drawn = 0;
    std::unique_lock lock(mutex_);
    while (!ends_.wait_until(lock, begin + next, [this] { return over_; })) {
        next += between;
        std::string text = describe(progress_, std::chrono::duration<double>(Clock::now() - begin).count());
        if (!terminal_) {
            std::fprintf(stderr, "%s\n", text.c_str());
            continue;
        }
        const std::size_t length = text.size();
        if (length < drawn) text.append(drawn - length, ' ');
        drawn = length;
        std::fprintf(stderr, "\r%s", text.c_str());
        std::fflush(stderr);
    }
    if (drawn > 0) std::fprintf(stderr, "\r%*s\r", static_cast<int>(drawn), "");
}

void LoadingLine::finish() {
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    ends_.notify_all();
    thread_.join();
}

}  // namespace raylex::experiments
