// Messages to people: where they go and how numbers read.
#pragma once

#include <cstddef>
#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Prints "raylex: error: ..." to standard error and returns the exit code for bad input.
int report_error(const Error& error);
/// The same for a sentence of our own.
int report_error(const std::string& message);
void print_warning(const std::string& message);  ///< to standard error
void print_note(const std::string& message);     ///< to standard error, where standard output is a file for others
void print_line(const std::string& text);        ///< to standard output, but see take_standard_output_for()

/// To standard output, as it stands.
void write_output(const std::string& text);
/// Whether what was written to standard output did not all get there, though somebody still reads it: `| head` is no
/// loss.
[[nodiscard]] bool output_is_lost();

/// Whether the name of a text file is that of standard output: "-".
[[nodiscard]] bool is_standard_output(const std::string& path);
/// Lines, verdicts among them, go to standard error from here on if this is standard output: what reads it expects the
/// text and nothing else.
void take_standard_output_for(const std::string& path);
/// To a file, or to standard output.
Status write_text(const std::string& path, const std::string& text);

[[nodiscard]] bool error_stream_is_terminal();

/// Shortest text that reads back as the same number to `digits` significant digits: "1.19e-07".
std::string number_text(double value, int digits = 3);
/// "0.42 s", "12.3 s", "3 min 20 s", "1 h 05 min".
std::string duration_text(double seconds);
/// "950 kB", "1.4 MB".
std::string size_text(double bytes);
/// "1 scene", "4 scenes"; `several` is the plural where an s does not make it.
std::string counted(std::size_t count, const std::string& one, const std::string& several = {});

}  // namespace raylex::experiments
