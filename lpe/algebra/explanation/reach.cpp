#include "lpe/algebra/explanation/reach.h"

#include <algorithm>
#include <utility>

namespace raylex::lpe {

namespace {

NodePtr copy_of(const Node& node) {
    NodePtr copy = make_node(node.kind);
    copy->events = node.events;
    copy->min = node.min;
    copy->max = node.max;
    for (const NodePtr& child : node.children) { copy->children.push_back(copy_of(*child)); }
    return placed(std::move(copy), node.begin, node.end);
}

NodePtr repeated(NodePtr child, int max) {
    NodePtr node = make_node(NodeKind::repeat);
    node->max = max;
    node->children.push_back(std::move(child));
    return node;
}

/// The words that the tree accepts on a way through `target`; null if the tree does not contain it, or if it only
/// excludes paths. A repetition keeps only its upper count, so the result can contain too many words, never too few.
NodePtr through(const Node& node, const Node* target) {
    if (&node == target) { return copy_of(node); }
    if (node.kind == NodeKind::complement || node.kind == NodeKind::event) { return nullptr; }
    const std::size_t children = node.kind == NodeKind::difference ? 1 : node.children.size();
    for (std::size_t k = 0; k < children; ++k) {
        NodePtr part = through(*node.children[k], target);
        if (!part) { continue; }
        if (node.kind == NodeKind::alternatives) { return part; }
        if (node.kind == NodeKind::repeat) {
            const int others = node.max == Node::unbounded ? Node::unbounded : std::max(node.max - 1, 0);
            NodePtr sequence = make_node(node.max == 0 ? NodeKind::alternatives : NodeKind::sequence);
            if (node.max != 0) {
                sequence->children.push_back(repeated(copy_of(*node.children.front()), others));
                sequence->children.push_back(std::move(part));
                sequence->children.push_back(repeated(copy_of(*node.children.front()), others));
            }
            return sequence;
        }
        NodePtr whole = make_node(node.kind);
        for (std::size_t i = 0; i < node.children.size(); ++i) {
            whole->children.push_back(i == k ? std::move(part) : copy_of(*node.children[i]));
        }
        return whole;
    }
    return nullptr;
}

void gather_events(const Node& node, std::size_t limit, std::vector<const Node*>& events) {
    if (events.size() >= limit || node.kind == NodeKind::complement) { return; }
    if (node.kind == NodeKind::event) { events.push_back(&node); }
    const std::size_t children = node.kind == NodeKind::difference ? 1 : node.children.size();
    for (std::size_t k = 0; k < children; ++k) { gather_events(*node.children[k], limit, events); }
}

}  // namespace

std::vector<const Node*> dead_events(const Node& root, std::size_t limit, const HasPath& has_path) {
    std::vector<const Node*> events;
    gather_events(root, limit, events);
    std::vector<NodePtr> trees;
    for (const Node* event : events) { trees.push_back(through(root, event)); }
    const std::vector<bool> alive = has_path(std::move(trees));
    std::vector<const Node*> dead;
    for (std::size_t k = 0; k < events.size(); ++k) {
        if (!alive[k]) { dead.push_back(events[k]); }
    }
    return dead;
}

const Node* first_dead_step(const Node& root, const HasPath& has_path) {
    const Node* sequence = &root;
    while (sequence->children.size() == 1 && sequence->kind != NodeKind::complement) {
        sequence = sequence->children.front().get();
    }
    if (sequence->kind != NodeKind::sequence) { return nullptr; }
    std::vector<NodePtr> trees;
    for (std::size_t k = 0; k < sequence->children.size(); ++k) {
        NodePtr prefix = make_node(NodeKind::sequence);
        for (std::size_t i = 0; i <= k; ++i) { prefix->children.push_back(copy_of(*sequence->children[i])); }
        EventSet all{{{{}, {}, Missing::is_empty, Extra::ignored}}, {}};
        all.any_of.front().cores.set();
        prefix->children.push_back(repeated(make_event(std::move(all)), Node::unbounded));
        trees.push_back(std::move(prefix));
    }
    const std::vector<bool> alive = has_path(std::move(trees));
    const auto first = std::find(alive.begin(), alive.end(), false);
    return first == alive.end() ? nullptr : sequence->children[static_cast<std::size_t>(first - alive.begin())].get();
}

}  // namespace raylex::lpe
