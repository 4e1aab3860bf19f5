// Finds pieces of an expression that no path of W uses.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "lpe/language/ast.h"

namespace raylex::lpe {

/// Returns for each tree whether its language contains a path of W. The function consumes the trees.
using HasPath = std::function<std::vector<bool>(std::vector<NodePtr> trees)>;

/// The single events of the tree that no path uses, outermost pieces first. Events below '!' and behind '-' are
/// skipped. At most `limit` events are tried. With repetition counts (`{2,5}`) a dead piece can be missed; a piece that
/// is reported is always dead.
[[nodiscard]] std::vector<const Node*> dead_events(const Node& root, std::size_t limit, const HasPath& has_path);

/// For an expression that matches no path: the first piece of its sequence after which no path can continue.
[[nodiscard]] const Node* first_dead_step(const Node& root, const HasPath& has_path);

}  // namespace raylex::lpe
