// The tree that a parser builds from an expression; all dialects share it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lpe/event.h"
#include "lpe/language/pattern.h"

namespace raylex::lpe {

enum class NodeKind : std::uint8_t {
    event,         ///< one event out of `events`
    sequence,      ///< the children one after the other; no children: the empty word
    alternatives,  ///< any one of the children; no children: nothing matches
    repeat,        ///< the child `min` to `max` times
    complement,    ///< every word of non-user events but the child's
    intersection,
    difference  ///< words of the first child that the second does not accept
};

struct Node {
    static constexpr int unbounded = -1;

    NodeKind kind = NodeKind::sequence;
    EventSet events;
    std::size_t event_set = 0;  ///< index of `events` among all sets of a compilation, assigned by build_languages
    int min = 0, max = 0;
    std::vector<std::unique_ptr<Node>> children;
    std::size_t begin = 0, end = 0;  ///< the node's bytes in the text; equal when it has none
};
using NodePtr = std::unique_ptr<Node>;

[[nodiscard]] inline NodePtr make_node(NodeKind kind) {
    auto node = std::make_unique<Node>();
    node->kind = kind;
    return node;
}
[[nodiscard]] inline NodePtr make_event(EventSet events) {
    NodePtr node = make_node(NodeKind::event);
    node->events = std::move(events);
    return node;
}

/// A parsed expression.
struct Expression {
    Dialect dialect = Dialect::renderman;
    NodePtr root;
    std::vector<std::string> prefixes;
    std::vector<std::string> warnings;
    bool has_bar = false;  ///< contains '|', so the two readings can differ
};

/// Sets the byte range of a node that was parsed from `begin` to `end`.
[[nodiscard]] inline NodePtr placed(NodePtr node, std::size_t begin, std::size_t end) {
    node->begin = begin;
    node->end = end;
    return node;
}
/// Gives a node without bytes of its own the byte range of its children.
[[nodiscard]] inline NodePtr placed_around_children(NodePtr node) {
    if (!node->children.empty()) {
        node->begin = node->children.front()->begin;
        node->end = node->children.back()->end;
    }
    return node;
}

/// The precedence of `|` against concatenation. Both dialects bind `|` tighter (`tight`). Other regular expressions
/// bind it looser, which people often expect, so both readings can be compared.
enum class BarReading : std::uint8_t { tight, loose };

}  // namespace raylex::lpe
