#include "lpe/algebra/graphs/graph.h"

#include <algorithm>
#include <map>
#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/failure.h"
#include "lpe/limits.h"
#include "lpe/match.h"

namespace raylex::lpe {

namespace {

constexpr std::size_t most_outputs = 32;   // an output has one bit for each channel
constexpr std::size_t label_columns = 28;  // lines of a label are broken behind so many characters

/// One automaton for all channels: bit k of an output is set if channel k matches.
Dfa together(const Languages& languages, std::size_t channels) {
    Dfa all = empty_dfa(languages.classes->count());
    for (std::size_t k = 0; k < channels; ++k) {
        Dfa one = intersection(*languages.words, languages.channels[k]);
        for (std::uint32_t& output : one.output) { output = output != 0 ? 1U << k : 0U; }
        all = required(product(all, one, union_of(), limits::boolean_states));
    }
    return all;
}

/// A shortest path to every state, found breadth first.
std::vector<std::vector<EventClass>> ways(const Dfa& dfa) {
    std::vector<std::vector<EventClass>> way(dfa.states());
    std::vector<bool> seen(dfa.states(), false);
    std::vector<std::uint32_t> queue{dfa.start};
    seen[dfa.start] = true;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        for (std::size_t k = 0; k < dfa.column_of_class.size(); ++k) {
            const std::uint32_t next = dfa.step(queue[i], static_cast<EventClass>(k));
            if (next != 0 && !seen[next]) {
                seen[next] = true;
                way[next] = way[queue[i]];
                way[next].push_back(static_cast<EventClass>(k));
                queue.push_back(next);
            }
        }
    }
    return way;
}

/// The edges that leave `state`, by target.
std::vector<GraphEdge> edges_from(std::uint32_t state, const Dfa& dfa, const EventClasses& classes,
                                  const EventTeller& teller, const EventTeller::Members& occurring) {
    std::vector<std::uint32_t> targets;
    for (std::size_t column = 0; column < dfa.columns; ++column) {
        const std::uint32_t target = dfa.next[state * dfa.columns + column];
        if (target != 0 && std::find(targets.begin(), targets.end(), target) == targets.end()) {
            targets.push_back(target);
        }
    }
    std::vector<GraphEdge> edges;
    for (const std::uint32_t target : targets) {
        const EventTeller::Members members = [&](const Event& event) {
            if (occurring(event) != Membership::in) { return Membership::never; }
            return dfa.step(state, classes.classify(event)) == target ? Membership::in : Membership::out;
        };
        GraphEdge edge{state - 1, target - 1, {}};
        for (const EventBox& box : teller.boxes(members)) {
            for (std::string& item : teller.notation(box)) {
                if (std::find(edge.items.begin(), edge.items.end(), item) == edge.items.end()) {
                    edge.items.push_back(std::move(item));
                }
            }
        }
        if (!edge.items.empty()) { edges.push_back(std::move(edge)); }
    }
    return edges;
}

Graph build(std::span<const ChannelSource> channels, const PathStrings& words) {
    if (channels.size() > most_outputs) {
        fail("found " + std::to_string(channels.size()) + " channels to draw; expected at most " +
             std::to_string(most_outputs));
    }
    PathStrings cut = path_strings_for(channels, words);
    cut.alphabet.reset();  // the labels of a whole scene would make every edge unreadable
    Question question = pose(channels, cut, nullptr, true);
    const EventClasses& classes = *question.languages.classes;
    const Dfa& all_path_strings = *question.languages.words;
    const Dfa dfa = together(question.languages, channels.size());
    if (dfa.states() - 1 > limits::graph_states) {
        fail("the automaton has " + std::to_string(dfa.states() - 1) + " states; expected at most " +
                 std::to_string(limits::graph_states) + ", because a larger drawing is unreadable",
             "draw fewer channels at a time");
    }
    Graph graph;
    graph.warnings = std::move(question.warnings);
    bool osl = !channels.empty();
    std::vector<const Node*> trees;
    for (std::size_t k = 0; k < channels.size(); ++k) {
        const std::string& name = channels[k].name;
        graph.channels.push_back(name.empty() ? channels[k].expression : name);
        osl = osl && channels[k].dialect == Dialect::osl;
        if (question.expressions[k].root) { trees.push_back(question.expressions[k].root.get()); }
    }
    const std::uint32_t under_way = all_path_strings.step(all_path_strings.start, classes.classify(Event{}));
    const EventTeller::Members occurring = [&](const Event& event) {
        const EventClass event_class = classes.classify(event);
        const bool occurs = all_path_strings.step(all_path_strings.start, event_class) != 0 ||
                            all_path_strings.step(under_way, event_class) != 0;
        return occurs ? Membership::in : Membership::never;
    };
    const EventSpace space(trees);
    const EventTeller teller(space, osl ? Dialect::osl : Dialect::renderman, occurring);
    const std::vector<std::vector<EventClass>> way = ways(dfa);
    for (std::uint32_t state = 1; state < dfa.states(); ++state) {
        GraphState entry;
        for (std::size_t k = 0; k < channels.size(); ++k) {
            if ((dfa.output[state] >> k & 1U) != 0) { entry.accepts.push_back(k); }
        }
        std::vector<Event> events;
        for (const EventClass event_class : way[state]) { events.push_back(classes.example(event_class)); }
        entry.reached_by = to_sentence(events);
        graph.states.push_back(std::move(entry));
        for (GraphEdge& edge : edges_from(state, dfa, classes, teller, occurring)) {
            graph.edges.push_back(std::move(edge));
        }
    }
    return graph;
}

std::string dot_text(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '"' || c == '\\') { escaped += '\\'; }
        if (c == '\n') {
            escaped += "\\n";
        } else if (static_cast<unsigned char>(c) >= 0x20) {
            escaped += c;
        }
    }
    return "\"" + escaped + "\"";
}

/// The events of an edge, several in a line.
std::string label_text(const std::vector<std::string>& items) {
    std::string label;
    std::size_t line = 0;  // where the last line begins
    for (const std::string& item : items) {
        const bool full = label.size() - line > label_columns;
        if (!label.empty()) { label += full ? '\n' : ' '; }
        if (full) { line = label.size(); }
        label += item;
    }
    return label;
}

}  // namespace

Result<Graph> graph_of(std::span<const ChannelSource> channels, const PathStrings& words) {
    return guarded([&] { return build(channels, words); });
}

std::string to_dot(const Graph& graph) {
    std::string dot =
        "digraph lpe {\n    rankdir=LR;\n"
        "    node [shape=circle, style=\"rounded,filled\", color=\"#45525e\", fillcolor=\"#e8edf2\", "
        "fontname=\"Helvetica\", fontsize=12, label=\"\", width=0.25];\n"
        "    edge [color=\"#45525e\", fontname=\"Courier\", fontsize=11];\n"
        "    begin [shape=none, style=\"\", width=0, height=0";
    dot += graph.states.empty() ? ", label=\"no path is accepted\"];\n" : "];\n    begin -> s0;\n";
    for (std::size_t k = 0; k < graph.states.size(); ++k) {
        dot += "    s" + std::to_string(k) + " [tooltip=" + dot_text(k == 0 ? "start" : graph.states[k].reached_by);
        std::string names;
        for (const std::size_t channel : graph.states[k].accepts) {
            names += (names.empty() ? "" : "\n") + graph.channels[channel];
        }
        dot += names.empty() ? "];\n"
                             : ", shape=box, peripheries=2, fillcolor=\"#dff0df\", label=" + dot_text(names) + "];\n";
    }
    for (const GraphEdge& edge : graph.edges) {
        dot += "    s" + std::to_string(edge.from) + " -> s" + std::to_string(edge.to) +
               " [label=" + dot_text(label_text(edge.items)) + "];\n";
    }
    return dot + "}\n";
}

}  // namespace raylex::lpe
