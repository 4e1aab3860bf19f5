// Messages for people, and texts of numbers.
#pragma once

#include <cstddef>
#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Prints "raylex: error: ..." to standard error and returns the exit code for bad input.
int report_error(const Error& error);
/// Prints "raylex: error: ..." with this message to standard error and returns the exit code for bad input.
int report_error(const std::string& message);
void print_warning(const std::string& message);  ///< to standard error
/// to standard error, because standard output may be a file for another program
void print_note(const std::string& message);
void print_line(const std::string& text);  ///< to standard output, unless take_standard_output_for() redirects it

/// Writes `text` to standard output unchanged.
void write_output(const std::string& text);
/// Returns whether a write to standard output failed. A reader that closed the pipe, such as `| head`, does not count.
[[nodiscard]] bool output_is_lost();

/// Returns whether the name of a text file means standard output: "-".
[[nodiscard]] bool is_standard_output(const std::string& path);
/// Redirects all later lines and results to standard error if `path` is standard output, because the program that reads
/// it expects only the text.
void take_standard_output_for(const std::string& path);
/// Writes `text` to a file, or to standard output.
Status write_text(const std::string& path, const std::string& text);

[[nodiscard]] bool error_stream_is_terminal();

/// Returns the number with `digits` significant digits: "1.19e-07".
std::string number_text(double value, int digits = 3);
/// Returns a duration as text: "0.42 s", "12.3 s", "3 min 20 s", "1 h 05 min".
std::string duration_text(double seconds);
/// Returns a size in bytes as text: "950 kB", "1.4 MB".
std::string size_text(double bytes);
/// Returns a count with its noun: "1 scene", "4 scenes". `several` is the plural; empty: `one` with an s.
std::string counted(std::size_t count, const std::string& one, const std::string& several = {});

}  // namespace raylex::experiments
