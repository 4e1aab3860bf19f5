// What of an expression of the `renderman` dialect is ours and not RenderMan's: texts offered to RenderMan have none of
// it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// Whose parser a text is for: ours, or RenderMan's own, which has no V, B, G, '?', '-', '&', '!' and no globs.
enum class Reader : std::uint8_t { raylex, renderman };

/// Each once, in the order of their first places: "V", "?", "&", "{n,m}", "a blank", "a glob in a label". `expression`
/// is one that parses, or a name.
[[nodiscard]] std::vector<std::string> extensions_in(std::string_view expression);

/// Whether volume scattering is named, so that its author counts on it.
[[nodiscard]] bool names_volume(std::string_view expression);

/// Errors, at the first place: what the expression has of ours, all of it named. Blanks and comments count unless
/// `without_blanks`. An expression of another dialect is not for RenderMan.
Status renderman_reads(const ChannelSource& source, bool without_blanks = false);

}  // namespace raylex::lpe
