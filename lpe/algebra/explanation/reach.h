// The pieces of an expression that take part in no path of W.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "lpe/language/ast.h"

namespace raylex::lpe {

/// Whether a tree's language has a path of W; the tree is thrown away.
using HasPath = std::function<std::vector<bool>(std::vector<NodePtr> trees)>;

/// The single events of the tree through which no path goes, outermost pieces first; events below '!' and behind '-'
/// are not looked at. At most `limit` events are tried. Where repetition counts are given (`{2,5}`) a piece may be dead
/// and not be found, never the contrary.
[[nodiscard]] std::vector<const Node*> dead_events(const Node& root, std::size_t limit, const HasPath& has_path);

/// For an expression that no path matches: the first piece of its sequence after which no path can go on.
[[nodiscard]] const Node* first_dead_step(const Node& root, const HasPath& has_path);

}  // namespace raylex::lpe
