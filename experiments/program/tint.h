// Coloured words in the terminal.
#pragma once

#include <string>

namespace raylex::experiments {

/// Chooses if words are coloured. automatic: on a terminal, unless $NO_COLOR is set or the terminal is "dumb".
enum class ColorChoice { automatic, always, never };
void choose_color(ColorChoice choice);

enum class Tint { error, warning, good, bad };
/// Returns the text, with colour codes if the output is coloured: standard error if `error_stream`, else standard
/// output.
[[nodiscard]] std::string tinted(const std::string& text, Tint tint, bool error_stream);

/// Prints a line like print_line(): green if a check holds, red if it does not.
void print_result(const std::string& text, bool holds);

}  // namespace raylex::experiments
