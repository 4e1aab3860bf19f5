// Names of expressions in the `renderman` dialect: the built-in names, and user-defined macros.
//
// A name can be a whole channel (`lpe:diffuse`, `diffuse`, `unoccluded;myDiffuse`), as in RenderMan. As an extension,
// `$name` or `${name}` inside an expression inserts the definition in parentheses. `NAME_GROUP` is the channel NAME for
// one light group: every `<L.>` of its expression becomes `<L.'GROUP'>`.
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

/// The built-in names, each with its published expression.
[[nodiscard]] std::span<const NamedExpression> builtin_names();

/// If the text after 'lpe:' and prefixes is only a name, returns the text from that name on; otherwise empty.
[[nodiscard]] std::string_view name_alone(std::string_view text);

/// User-defined macros.
class MacroTable {
  public:
    /// Adds a macro. Errors: an invalid name, a name that reads as an expression (`CDL`) or is already defined; an
    /// empty expression.
    Status add(ChannelSource definition);
    [[nodiscard]] const ChannelSource* find(std::string_view name) const;
    [[nodiscard]] const std::vector<ChannelSource>& list() const { return list_; }
    [[nodiscard]] bool empty() const { return list_.empty(); }

  private:
    std::vector<ChannelSource> list_;
    std::map<std::string, std::size_t, std::less<>> index_;
};

struct Expansion {
    ChannelSource source;  ///< without names; its map leads to the definitions
    std::vector<std::string> warnings;
};

/// Replaces names by their definitions: user macros take precedence over built-in names. Channels of other dialects,
/// which have no names, are returned unchanged. Errors: an unknown name; names that use one another in a circle, which
/// the error shows; a macro with prefixes inside an expression.
Result<Expansion> expand_names(const ChannelSource& source, const MacroTable& macros = {});

}  // namespace raylex::lpe
