#include "lpe/algebra/wording/path_roles.h"

#include <algorithm>
#include <array>

namespace raylex::lpe {

namespace {

struct Move {
    EventRole role;
    ProgressSet from, to;
};
constexpr std::array<Move, 4> moves{{{EventRole::camera, before_camera, under_way},
                                     {EventRole::scattering, under_way, under_way},
                                     {EventRole::user, under_way, under_way},
                                     {EventRole::terminal, under_way, ended}}};

bool has_role(const EventSet& set, EventRole role) {
    for (const EventPattern& pattern : set.any_of) {
        for (std::size_t core = 0; core < core_count; ++core) {
            if (pattern.cores[core] && role_of(core_event(core).type) == role) { return true; }
        }
    }
    return false;
}

/// The progress that a path can reach from `in`.
ProgressSet any_later(ProgressSet in) {
    return static_cast<ProgressSet>(in | ((in & before_camera) != 0 ? under_way | ended : 0) |
                                    ((in & under_way) != 0 ? ended : 0));
}
ProgressSet any_earlier(ProgressSet out) {
    return static_cast<ProgressSet>(out | ((out & ended) != 0 ? under_way | before_camera : 0) |
                                    ((out & under_way) != 0 ? before_camera : 0));
}

/// Progress never decreases, so further rounds of the same child change nothing.
constexpr int settled = 4;
int rounds(const Node& repeat) {
    const int most = std::min(repeat.min, settled) + settled;
    return repeat.max == Node::unbounded ? most : std::min(repeat.max, most);
}

}  // namespace

PathRoles::PathRoles(const Node& root) {
    forward(root, before_camera);
    possible_ = (backward(root, ended) & before_camera) != 0;
}

/// The possible progress of a path after the node.
ProgressSet PathRoles::forward(const Node& node, ProgressSet in) {
    std::optional<ProgressSet>& answer = known_[&node].forward[in];
    if (!answer) {
        answer = forward_once(node, in);  // references into an unordered_map stay valid
    }
    return *answer;
}

ProgressSet PathRoles::forward_once(const Node& node, ProgressSet in) {
    known_[&node].reached |= in;
    ProgressSet out = 0;
    switch (node.kind) {
        case NodeKind::event:
            for (const Move& move : moves) {
                if ((in & move.from) != 0 && has_role(node.events, move.role)) { out |= move.to; }
            }
            return out;
        case NodeKind::sequence:
            out = in;
            for (const NodePtr& child : node.children) { out = forward(*child, out); }
            return out;
        case NodeKind::alternatives:
            for (const NodePtr& child : node.children) { out |= forward(*child, in); }
            return out;
        case NodeKind::repeat: {
            ProgressSet now = in;
            out = node.min == 0 ? in : ProgressSet{0};
            for (int i = 1; i <= rounds(node); ++i) {
                now = forward(*node.children.front(), now);
                out |= i >= std::min(node.min, settled) ? now : ProgressSet{0};
            }
            return out;
        }
        case NodeKind::intersection:
            out = forward(*node.children.front(), in);
            return out & forward(*node.children.back(), in);
        case NodeKind::difference:
            out = forward(*node.children.front(), in);
            forward(*node.children.back(), in);
            return out;
        case NodeKind::complement:
            forward(*node.children.front(), in);
            return any_later(in);
    }
    return out;
}

/// The possible progress of a path before the node, given `out` after it. All rounds of a repetition are treated alike.
ProgressSet PathRoles::backward(const Node& node, ProgressSet out) {
    std::optional<ProgressSet>& answer = known_[&node].backward[out];
    if (!answer) { answer = backward_once(node, out); }
    return *answer;
}

ProgressSet PathRoles::backward_once(const Node& node, ProgressSet out) {
    known_[&node].range.out |= out;
    ProgressSet in = 0;
    switch (node.kind) {
        case NodeKind::event:
            for (const Move& move : moves) {
                if ((out & move.to) != 0 && has_role(node.events, move.role)) { in |= move.from; }
            }
            break;
        case NodeKind::sequence:
            in = out;
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
                in = backward(**child, in);
            }
            break;
        case NodeKind::alternatives:
            for (const NodePtr& child : node.children) { in |= backward(*child, out); }
            break;
        case NodeKind::repeat: {
            in = node.min == 0 ? out : ProgressSet{0};
            ProgressSet now = out;
            for (int i = 1; i <= rounds(node); ++i) {
                now = backward(*node.children.front(), now);
                in |= i >= std::min(node.min, settled) ? now : ProgressSet{0};
            }
            break;
        }
        case NodeKind::intersection:
            in = backward(*node.children.front(), out);
            in &= backward(*node.children.back(), out);
            break;
        case NodeKind::difference:
            in = backward(*node.children.front(), out);
            backward(*node.children.back(), out);
            break;
        case NodeKind::complement:
            backward(*node.children.front(), out);
            in = any_earlier(out);
            break;
    }
    Known& known = known_[&node];
    in &= known.reached;
    known.range.in |= in;
    return in;
}

bool PathRoles::can_be(const Node& event, EventRole role) const {
    const auto place = known_.find(&event);
    if (!possible_ || place == known_.end()) { return !possible_; }
    const Range& range = place->second.range;
    return std::any_of(moves.begin(), moves.end(), [&](const Move& move) {
        return move.role == role && (range.in & move.from) != 0 && (range.out & move.to) != 0;
    });
}

ProgressSet PathRoles::after(const Node& node) const {
    const auto place = known_.find(&node);
    return place == known_.end() ? ProgressSet{0} : place->second.range.out;
}

}  // namespace raylex::lpe
