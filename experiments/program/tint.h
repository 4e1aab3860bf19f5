// Coloured words in a terminal.
#pragma once

#include <string>

namespace raylex::experiments {

/// When words are coloured: automatic is where a terminal shows them, unless $NO_COLOR says no or the terminal is
/// "dumb".
enum class ColorChoice { automatic, always, never };
void choose_color(ColorChoice choice);

enum class Tint { error, warning, good, bad };
/// The text in that colour, when what is written to standard error (or else standard output) is to be coloured.
[[nodiscard]] std::string tinted(const std::string& text, Tint tint, bool error_stream);

/// As print_line() does, green where a check holds and red where it does not.
void print_verdict(const std::string& text, bool holds);

}  // namespace raylex::experiments
