// Names for expressions in the `renderman` dialect: the built-in ones, and macros that users define.
//
// A name stands for a whole channel (`lpe:diffuse`, `diffuse`, `unoccluded;myDiffuse`), as in RenderMan, or inside an
// expression as `$name` or `${name}` (ours), where it reads as if it stood in parentheses. `NAME_GROUP` is the channel
// of that name for one light group: every `<L.>` of its expression becomes `<L.'GROUP'>`.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/shipped.h"

namespace raylex::lpe {

/// The names that need no definition, each with its published expression.
[[nodiscard]] std::span<const NamedExpression> builtin_names();

/// The end of the text from the name on that is all there is behind 'lpe:' and prefixes; empty where an expression
/// stands there.
[[nodiscard]] std::string_view name_alone(std::string_view text);

/// What users define.
class MacroTable {
  public:
    /// Errors: a name that cannot be one, reads as an expression (`CDL`), or is defined already; an empty expression.
    Status add(ChannelSource definition);
    [[nodiscard]] const ChannelSource* find(std::string_view name) const;
    [[nodiscard]] const std::vector<ChannelSource>& list() const { return list_; }
    [[nodiscard]] bool empty() const { return list_.empty(); }

  private:
    std::vector<ChannelSource> list_;
    std::map<std::string, std::size_t, std::less<>> index_;
};

struct Expansion {
    ChannelSource source;  ///< without names; its map leads back to the definitions
    std::vector<std::string> warnings;
};

/// Replaces names by what they stand for: the user's macros first, then the built-in ones. Other dialects have no
/// names: their channels come back as they are. Errors: an unknown name, names that use one another in a circle (the
/// circle is shown), a macro with prefixes inside an expression.
Result<Expansion> expand_names(const ChannelSource& source, const MacroTable& macros = {});

}  // namespace raylex::lpe
