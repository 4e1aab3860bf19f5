#include "lpe/algebra/explanation/why_not.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "lpe/algebra/wording/event_words.h"
#include "lpe/algebra/wording/path_roles.h"
#include "lpe/automata/languages.h"
#include "lpe/failure.h"
#include "lpe/language/names.h"
#include "lpe/language/parser/parser.h"

namespace raylex::lpe {

namespace {

constexpr std::size_t most_marked_events = 200;

/// Collects the events of a tree in text order; sets `operators` if the tree contains '!', '&' or '-'.
void gather(const Node& node, std::vector<const Node*>& events, bool& operators) {
    if (node.kind == NodeKind::event) { events.push_back(&node); }
    operators = operators || node.kind == NodeKind::complement || node.kind == NodeKind::intersection ||
                node.kind == NodeKind::difference;
    for (const NodePtr& child : node.children) { gather(*child, events, operators); }
}

/// A marker for the k-th event of the expression: user event 0, which matches no pattern.
Event marker(std::size_t k) {
    return {EventType::user, Scatter::none, 0, {std::to_string(k)}};
}

/// A copy of the tree in which the k-th event also matches the k-th marker.
NodePtr marked(const Node& node, std::size_t& k) {
    NodePtr copy = make_node(node.kind);
    copy->events = node.events;
    copy->min = node.min;
    copy->max = node.max;
    for (const NodePtr& child : node.children) { copy->children.push_back(marked(*child, k)); }
    if (node.kind != NodeKind::event) { return copy; }
    const Event mark = marker(k++);
    EventPattern pattern{{}, {{false, mark.labels, {}}}, Missing::is_empty, Extra::ignored};
    pattern.cores.set(core_index(mark));
    NodePtr choice = make_node(NodeKind::alternatives);
    choice->children.push_back(std::move(copy));
    choice->children.push_back(make_event({{std::move(pattern)}, {}}));
    return choice;
}

std::uint32_t after(const Dfa& dfa, const EventClasses& classes, std::span<const Event> events) {
    std::uint32_t state = dfa.start;
    for (const Event& event : events) { state = dfa.step(state, classes.classify(event)); }
    return state;
}

Languages automaton(const ChannelSource& source, NodePtr tree) {
    std::vector<Expression> expressions;
    expressions.emplace_back();
    expressions.back().dialect = source.dialect;
    expressions.back().root = std::move(tree);
    return build_languages({&source, 1}, expressions, {});
}

/// The events of the expression that can follow the prefix.
std::vector<const Node*> next_events(const ChannelSource& source, const Node& root, std::span<const Event> prefix,
                                     const std::vector<const Node*>& events) {
    std::size_t count = 0;
    const Languages languages = automaton(source, marked(root, count));
    const Dfa& dfa = languages.channels.front();
    const std::uint32_t state = after(dfa, *languages.classes, prefix);
    std::vector<const Node*> next;
    for (std::size_t k = 0; k < events.size(); ++k) {
        if (dfa.step(state, languages.classes->classify(marker(k))) != 0) { next.push_back(events[k]); }
    }
    return next;
}

/// "one diffuse scattering or a light of group 'key'"
std::string wanted_words(const EventTeller& teller, const EventTeller::Members& members) {
    const std::vector<EventBox> boxes = teller.boxes(members);
    std::vector<std::string> items;
    for (const EventBox& box : boxes) {
        const EventPhrase phrase = teller.phrase(box);
        for (const std::string& one : phrase.one) {
            items.push_back(box.role == EventRole::camera     ? "the camera"
                            : box.role == EventRole::terminal ? one
                                                              : "one " + one);
        }
    }
    return joined_by(items);
}

/// Names the labels of `event` that keep it out of patterns that accept its type and scattering.
std::string label_hint(const Event& event, const std::vector<const Node*>& next) {
    for (const Node* node : next) {
        for (const EventPattern& pattern : node->events.any_of) {
            if (!pattern.cores[core_index(event)]) { continue; }
            for (std::size_t slot = 0; slot < pattern.labels.size(); ++slot) {
                const LabelTest& test = pattern.labels[slot];
                const std::string label = slot < event.labels.size() ? event.labels[slot] : "";
                if (test.negated || test.names.empty() || test.matches(label)) { continue; }
                const std::vector<std::string_view> names(test.names.begin(), test.names.end());
                const std::string near = nearest(label, names.data(), names.size());
                std::vector<std::string> quoted;
                for (const std::string& name : test.names) { quoted.push_back("'" + name + "'"); }
                const std::string found =
                    label.empty() ? "it has no label where " : "its label '" + label + "' is not ";
                return found + joined_by(shortened(std::move(quoted))) + (label.empty() ? " is required" : "") +
                       (near.empty() ? "" : "; did you mean '" + near + "'?");
            }
        }
    }
    return {};
}

/// Follows the path as long as it is a prefix of an accepted path; returns the automaton's state there.
std::uint32_t walk_along(std::span<const Event> events, const Dfa& dfa, const EventClasses& classes, WhyNot& answer) {
    std::uint32_t state = dfa.start;
    answer.any_path = state != 0;
    while (state != 0 && answer.live_events < events.size()) {
        const std::uint32_t next = dfa.step(state, classes.classify(events[answer.live_events]));
        if (next == 0) { break; }
        state = next;
        ++answer.live_events;
    }
    answer.complete = dfa.output[state] != 0;
    answer.matches = answer.complete && answer.live_events == events.size();
    return state;
}

WhyNot reason(const ChannelSource& channel, std::span<const Event> events) {
    Result<Expansion> expansion = expand_names(channel);
    if (!expansion) { throw Failure{std::move(expansion).error()}; }
    const ChannelSource& source = expansion->source;
    WhyNot answer;
    answer.expression = source.expression;
    const Expression expression = parse(source);
    Languages languages = automaton(source, std::move(parse(source).root));
    const Dfa& dfa = languages.channels.front();
    const EventClasses& classes = *languages.classes;
    const std::uint32_t state = walk_along(events, dfa, classes, answer);
    if (answer.matches || !answer.any_path) { return answer; }
    std::vector<const Node*> all;
    bool operators = false;
    gather(*expression.root, all, operators);
    bool by_piece = !operators && all.size() <= most_marked_events;
    std::vector<const Node*> next;
    if (by_piece) {
        try {
            next = next_events(source, *expression.root, events.first(answer.live_events), all);
        } catch (const Failure&) {
            by_piece = false;  // the markers make the automaton too large; the unmarked automaton still gives the
                               // possible next events
        }
    }
    const PathRoles roles(*expression.root);
    const EventTeller::Members occurring = [&](const Event& event) {
        const bool absent = event.scatter == Scatter::straight && source.dialect == Dialect::renderman;
        return absent ? Membership::never : Membership::in;
    };
    const EventTeller::Members members = [&](const Event& event) {
        if (occurring(event) != Membership::in) { return Membership::never; }
        if (!by_piece) {
            if ((role_of(event.type) == EventRole::camera) != (answer.live_events == 0)) { return Membership::never; }
            return dfa.step(state, classes.classify(event)) != 0 ? Membership::in : Membership::out;
        }
        const bool in = std::any_of(next.begin(), next.end(), [&](const Node* node) {
            return roles.can_be(*node, role_of(event.type)) && matches(node->events, event);
        });
        return in ? Membership::in : Membership::out;
    };
    const EventSpace space({expression.root.get()});
    const EventTeller teller(space, source.dialect, occurring);
    answer.wanted = wanted_words(teller, members);
    for (const Node* node : next) { answer.pieces.push_back({node->begin, node->end}); }
    if (answer.live_events < events.size()) { answer.hint = label_hint(events[answer.live_events], next); }
    return answer;
}

}  // namespace

Result<WhyNot> why_not(const ChannelSource& channel, std::span<const Event> events) {
    return guarded([&] { return reason(channel, events); });
}

}  // namespace raylex::lpe
