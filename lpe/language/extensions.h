// Finds raylex's extensions in an expression of the `renderman` dialect. Texts for RenderMan must not contain any.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// The parser that a text is for: raylex's, or RenderMan's own, which lacks V, B, G, '?', '-', '&', '!' and globs.
enum class Reader : std::uint8_t { raylex, renderman };

/// The extensions in the expression, each once, in the order of their first occurrence: "V", "?", "&", "{n,m}", "a
/// blank", "a glob in a label". `expression` is a name or an expression that parses.
[[nodiscard]] std::vector<std::string> extensions_in(std::string_view expression);

/// Returns whether the expression names volume scattering, so that its author expects it.
[[nodiscard]] bool names_volume(std::string_view expression);

/// Checks that RenderMan supports the expression. The error is at the first extension and names all of them. Blanks and
/// comments count unless `without_blanks`. An expression of another dialect is an error.
Status renderman_reads(const ChannelSource& source, bool without_blanks = false);

}  // namespace raylex::lpe
