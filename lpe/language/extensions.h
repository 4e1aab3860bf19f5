// What of an expression of the `renderman` dialect is ours and not RenderMan's: texts offered to RenderMan have none of
// it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raylex::lpe {

/// Each once, in the order of their first places: "V", "?", "&", "{n,m}", "a blank", "a glob in a label". `expression`
/// is one that parses.
[[nodiscard]] std::vector<std::string> extensions_in(std::string_view expression);

/// Whether volume scattering is named, so that its author counts on it.
[[nodiscard]] bool names_volume(std::string_view expression);

}  // namespace raylex::lpe
