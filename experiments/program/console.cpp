#include "experiments/program/console.h"

#include <unistd.h>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "display/output/atomic_file.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/tint.h"

namespace raylex::experiments {

namespace {

ColorChoice chosen_color = ColorChoice::automatic;
bool lines_to_error_stream = false;

bool is_colored(int descriptor) {
    if (chosen_color != ColorChoice::automatic) return chosen_color == ColorChoice::always;
    const char* refused = std::getenv("NO_COLOR");  // no-color.org: set and not empty
    const char* terminal = std::getenv("TERM");
    return isatty(descriptor) == 1 && (refused == nullptr || *refused == '\0') && terminal != nullptr &&
           std::string_view(terminal) != "dumb";
}

/// Replaces control characters. Names come from files: a zero byte would cut the message, others could control the
/// terminal.
std::string printable(std::string text) {
    for (char& c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if ((byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f) c = '?';
    }
    return text;
}

int output_failure = 0;  // errno of the first write to standard output that failed

void note_output(bool is_written) {
    if (!is_written && output_failure == 0) output_failure = errno;
}

void print_tinted(const std::string& text) {
    if (lines_to_error_stream) std::fprintf(stderr, "%s\n", text.c_str());
    else write_output(text + "\n");
}

}  // namespace

void choose_color(ColorChoice choice) {
    chosen_color = choice;
}

std::string tinted(const std::string& text, Tint tint, bool error_stream) {
    if (!is_colored(error_stream ? STDERR_FILENO : STDOUT_FILENO)) return text;
    const char* code = tint == Tint::good ? "\x1b[32m" : tint == Tint::warning ? "\x1b[1;33m" : "\x1b[1;31m";
    return code + text + "\x1b[0m";
}

void write_output(const std::string& text) {
    note_output(std::fwrite(text.data(), 1, text.size(), stdout) == text.size());
}

bool output_is_lost() {
    note_output(std::fflush(stdout) == 0);
    return output_failure != 0 && output_failure != EPIPE;
}

int report_error(const std::string& message) {
    note_output(std::fflush(stdout) == 0);
    std::fprintf(stderr, "raylex: %s %s\n", tinted("error:", Tint::error, true).c_str(), printable(message).c_str());
    return exit_bad_input;
}

int report_error(const Error& error) {
    return report_error(error.to_string());
}

void print_warning(const std::string& message) {
    std::fprintf(stderr, "raylex: %s %s\n", tinted("warning:", Tint::warning, true).c_str(),
                 printable(message).c_str());
}

void print_note(const std::string& message) {
    std::fprintf(stderr, "raylex: %s\n", printable(message).c_str());
}

void print_line(const std::string& text) {
    print_tinted(printable(text));
}

bool is_standard_output(const std::string& path) {
    return path == "-";
}

void take_standard_output_for(const std::string& path) {
    lines_to_error_stream = lines_to_error_stream || is_standard_output(path);
}

Status write_text(const std::string& path, const std::string& text) {
    if (!is_standard_output(path)) return display::write_text_file(path, text);
    write_output(text);
    return success();
}

void print_result(const std::string& text, bool holds) {
    print_tinted(tinted(printable(text), holds ? Tint::good : Tint::bad, lines_to_error_stream));
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

std::string counted(std::size_t count, const std::string& one, const std::string& several) {
    if (count == 1) return "1 " + one;
    return std::to_string(count) + " " + (several.empty() ? one + "s" : several);
}

}  // namespace raylex::experiments
