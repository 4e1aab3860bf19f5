#include "experiments/cli/console.h"

#include <unistd.h>
#include <array>
#include <cmath>
#include <cstdio>

#include "experiments/cli/command_line.h"

namespace raylex::experiments {

int report_error(const std::string& message) {
    std::fflush(stdout);
    std::fprintf(stderr, "raylex: error: %s\n", message.c_str());
    return exit_bad_input;
}

int report_error(const Error& error) {
    return report_error(error.to_string());
}

void print_warning(const std::string& message) {
    std::fprintf(stderr, "raylex: warning: %s\n", message.c_str());
}

void print_note(const std::string& message) {
    std::fprintf(stderr, "raylex: %s\n", message.c_str());
}

void print_line(const std::string& text) {
    std::printf("%s\n", text.c_str());
}

bool error_stream_is_terminal() {
    return isatty(STDERR_FILENO) == 1;
}

std::string number_text(double value, int digits) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
}

std::string duration_text(double seconds) {
    std::array<char, 64> text{};
    if (seconds < 10) {
        std::snprintf(text.data(), text.size(), "%.2f s", seconds);
    } else if (seconds < 100) {
        std::snprintf(text.data(), text.size(), "%.1f s", seconds);
    } else {
        const auto whole = static_cast<long>(std::llround(seconds));
        if (whole < 3600) std::snprintf(text.data(), text.size(), "%ld min %02ld s", whole / 60, whole % 60);
        else std::snprintf(text.data(), text.size(), "%ld h %02ld min", whole / 3600, whole / 60 % 60);
    }
    return text.data();
}

std::string size_text(double bytes) {
    std::array<char, 64> text{};
    if (bytes < 1e6) std::snprintf(text.data(), text.size(), "%.0f kB", std::ceil(bytes / 1e3));
    else if (bytes < 1e9) std::snprintf(text.data(), text.size(), "%.1f MB", bytes / 1e6);
    else std::snprintf(text.data(), text.size(), "%.1f GB", bytes / 1e9);
    return text.data();
}

}  // namespace raylex::experiments
