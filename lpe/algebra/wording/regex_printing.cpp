// State elimination (Brzozowski and McCluskey): removes states one by one and moves the expressions of the ways through
// each state to the edges between its neighbours. The order decides the length of the text, so several orders are
// tried.
#include "lpe/algebra/wording/regex_printing.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/event_text.h"
#include "lpe/algebra/wording/regex.h"
#include "lpe/automata/languages.h"
#include "lpe/failure.h"
#include "lpe/language/extensions.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

constexpr std::size_t most_states = 40;  // more states would give a long text

/// The event classes of each role in a path.
struct Roles {
    ClassSet camera, scattering, terminal;
};

Roles find_roles(const Languages& languages) {
    const Dfa& words = *languages.words;
    const std::size_t count = languages.classes->count();
    Roles roles{ClassSet(count, false), ClassSet(count, false), ClassSet(count, false)};
    std::uint32_t after_camera = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t target = words.step(words.start, static_cast<EventClass>(k));
        roles.camera[k] = target != 0;
        after_camera = target != 0 ? target : after_camera;
    }
    for (std::size_t k = 0; k < count; ++k) {
        const Event& example = languages.classes->example(static_cast<EventClass>(k));
        const std::uint32_t target = words.step(after_camera, static_cast<EventClass>(k));
        if (target == 0 || example.scatter == Scatter::straight) {
            continue;  // in this dialect pass-through events leave no event
        }
        (words.output[target] != 0 ? roles.terminal : roles.scattering)[k] = true;
    }
    return roles;
}

/// The automaton with an expression on every edge. State `states` is the only accepting state.
struct Graph {
    std::size_t end = 0, start = 0;
    std::map<std::pair<std::size_t, std::size_t>, RegexPtr> edges;
};

/// States from which an accepting state is reachable.
std::vector<bool> live_states(const Dfa& dfa) {
    std::vector<bool> live(dfa.states(), false);
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t state = 1; state < dfa.states(); ++state) {
            bool now = dfa.output[state] != 0;
            for (std::size_t column = 0; column < dfa.columns && !now; ++column) {
                now = live[dfa.next[state * dfa.columns + column]];
            }
            changed = changed || now != live[state];
            live[state] = now;
        }
    }
    return live;
}

Graph graph_of(const Dfa& dfa, const Roles& roles, RegexBuilder& builder) {
    Graph graph;
    graph.start = dfa.start;
    graph.end = dfa.states();
    const std::vector<bool> live = live_states(dfa);
    for (std::uint32_t state = 1; state < dfa.states(); ++state) {
        std::map<std::uint32_t, ClassSet> sets;
        for (std::size_t k = 0; k < dfa.column_of_class.size(); ++k) {
            const std::uint32_t target = dfa.step(state, static_cast<EventClass>(k));
            const bool event = roles.camera[k] || roles.scattering[k] || roles.terminal[k];
            if (live[state] && live[target] && target != 0 && event) {
                sets.try_emplace(target, dfa.column_of_class.size(), false).first->second[k] = true;
            }
        }
        for (auto& [target, set] : sets) { graph.edges[{state, target}] = builder.events(std::move(set)); }
        if (dfa.output[state] != 0) { graph.edges[{state, graph.end}] = builder.epsilon(); }
    }
    return graph;
}

void eliminate(Graph& graph, std::size_t state, RegexBuilder& builder) {
    std::vector<std::pair<std::size_t, RegexPtr>> in, out;
    RegexPtr loop;
    for (const auto& [ends, regex] : graph.edges) {
        if (ends.first == state && ends.second == state) {
            loop = regex;
        } else if (ends.first == state) {
            out.emplace_back(ends.second, regex);
        } else if (ends.second == state) {
            in.emplace_back(ends.first, regex);
        }
    }
    std::erase_if(graph.edges,
                  [&](const auto& edge) { return edge.first.first == state || edge.first.second == state; });
    const RegexPtr round = builder.star(loop);
    for (const auto& [from, first] : in) {
        for (const auto& [to, last] : out) {
            const RegexPtr way = builder.sequence(builder.sequence(first, round), last);
            RegexPtr& edge = graph.edges[{from, to}];
            edge = builder.alternatives(edge, way);
        }
    }
}

/// The length of the text that removing the state would add.
std::size_t cost(const Graph& graph, std::size_t state) {
    std::size_t ins = 0, outs = 0, in_text = 0, out_text = 0, loop_text = 0;
    for (const auto& [ends, regex] : graph.edges) {
        const bool into = ends.second == state, from = ends.first == state;
        if (into && from) {
            loop_text += regex->text.size() + 1;
        } else if (into) {
            ++ins;
            in_text += regex->text.size();
        } else if (from) {
            ++outs;
            out_text += regex->text.size();
        }
    }
    return in_text * outs + out_text * ins + loop_text * ins * outs;
}

enum class Order { cheapest, from_the_end, from_the_start };

std::optional<std::string> eliminated(Graph graph, Order order, RegexBuilder builder) {
    std::vector<std::size_t> left;
    for (std::size_t state = 1; state < graph.end; ++state) {
        if (state != graph.start) { left.push_back(state); }
    }
    while (!left.empty() && !builder.failed()) {
        std::size_t pick = order == Order::from_the_end ? left.size() - 1 : 0;
        if (order == Order::cheapest) {
            const auto cheapest = std::min_element(left.begin(), left.end(), [&](std::size_t a, std::size_t b) {
                return cost(graph, a) < cost(graph, b);
            });
            pick = static_cast<std::size_t>(cheapest - left.begin());
        }
        eliminate(graph, left[pick], builder);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(pick));
    }
    // No edge returns to the start, because no word has a second camera.
    const auto whole = graph.edges.find({graph.start, graph.end});
    if (builder.failed() || whole == graph.edges.end() || graph.edges.count({graph.start, graph.start}) != 0) {
        return std::nullopt;
    }
    return builder.text(whole->second);
}

std::optional<std::string> text_of(const Dfa& language, const Languages& languages, const SlotLabels& labels,
                                   Reader reader = Reader::raylex) {
    if (language.states() > most_states || language.start == 0) { return std::nullopt; }
    const Roles roles = find_roles(languages);
    const EventWriter writer(*languages.classes, labels, reader == Reader::raylex);
    // A terminal item must not match scattering events, and must not match other terminals; scattering items likewise:
    // [LO] and not '.', although W would allow it. Events on no path of W are free.
    std::map<ClassSet, std::optional<std::string>> written;
    const auto write = [&](const ClassSet& wanted) -> std::optional<std::string> {
        const auto [place, fresh] = written.try_emplace(wanted);
        if (fresh) {
            ClassSet avoided(wanted.size(), false);
            bool scatters = false;
            for (std::size_t k = 0; k < wanted.size(); ++k) {
                scatters = scatters || (wanted[k] && roles.scattering[k]);
            }
            for (std::size_t k = 0; k < wanted.size(); ++k) {
                const bool relevant = scatters ? roles.scattering[k] : roles.scattering[k] || roles.terminal[k];
                avoided[k] = relevant && !wanted[k];
            }
            place->second = writer.write(wanted, avoided);
        }
        return place->second;
    };
    // Intermediate texts can be longer than the result.
    RegexBuilder builder(write, 8 * longest_printed_expression, reader == Reader::raylex);
    const Graph graph = graph_of(language, roles, builder);
    if (builder.failed()) { return std::nullopt; }
    std::optional<std::string> best;
    for (const Order order : {Order::cheapest, Order::from_the_end, Order::from_the_start}) {
        std::optional<std::string> text = eliminated(graph, order, builder);
        if (text && reader == Reader::renderman && !extensions_in(*text).empty()) { continue; }
        if (text && (!best || text->size() < best->size())) { best = std::move(text); }
    }
    return best && best->size() <= longest_printed_expression ? best : std::nullopt;
}

/// The channels and W as automata, with the labels that the channels name.
struct PrintingQuestion {
    Languages languages;
    SlotLabels labels;
};

PrintingQuestion pose_for_printing(std::span<const ChannelSource> channels, const PathStrings& words) {
    PrintingQuestion question;
    LanguageOptions options;
    options.words = &words;
    std::vector<Expression> expressions;
    for (const ChannelSource& channel : channels) {
        if (!channel.rest_of.empty()) {
            expressions.emplace_back();
            continue;
        }
        options.skip_reserved_labels = options.skip_reserved_labels || channel.dialect == Dialect::osl;
        expressions.push_back(parse(channel));
        question.labels.gather(*expressions.back().root);
    }
    question.languages = build_languages(channels, expressions, options);
    return question;
}

ChannelSource printed(const std::string& text) {
    ChannelSource source;
    source.name = "printed";
    source.expression = text;
    return source;
}

/// The paths of the beauty that no channel counts, restricted to `words`, as text.
std::optional<std::string> left_over(std::span<const ChannelSource> channels,
                                     const std::optional<ChannelSource>& beauty, const PathStrings& words,
                                     Reader reader) {
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    const std::size_t count = all.size();
    if (beauty) { all.push_back(*beauty); }
    ChannelSource rest;
    rest.name = "rest";
    for (std::size_t k = 0; k < count; ++k) { rest.rest_of.push_back(k); }
    all.push_back(std::move(rest));
    const PrintingQuestion question = pose_for_printing(all, words);
    if (question.labels.deeper) { return std::nullopt; }
    Dfa language = question.languages.channels.back();
    if (beauty) {
        const auto cut =
            product(language, question.languages.channels[count], intersection_of(), limits::boolean_states);
        if (!cut) { return std::nullopt; }
        language = minimized(*cut);
    }
    return text_of(language, question.languages, question.labels, reader);
}

/// W itself, and W with fewer restrictions: a rest for a larger W is also a rest for a smaller one, and its text is
/// often shorter.
std::vector<PathStrings> worlds_around(const PathStrings& words) {
    PathStrings wider = words;
    wider.alphabet.reset();
    wider.max_depth.reset();
    wider.light_groups.reset();
    wider.object_labels.reset();
    wider.unlabelled_lights = true;
    std::vector<PathStrings> worlds{wider};
    if (words.alphabet) {
        const auto any_of_type = [](const std::vector<Event>& events, EventType type) {
            return std::any_of(events.begin(), events.end(), [type](const Event& e) { return e.type == type; });
        };
        PathStrings same_types = wider;
        same_types.volume = words.volume && any_of_type(words.alphabet->scattering, EventType::volume);
        same_types.emission = words.emission && any_of_type(words.alphabet->terminals, EventType::emission);
        worlds.push_back(same_types);
    }
    if (words.alphabet || words.max_depth || words.light_groups || words.object_labels || !words.unlabelled_lights) {
        worlds.push_back(words);
    }
    return worlds;
}

std::optional<std::string> rest_text(std::span<const ChannelSource> channels,
                                     const std::optional<ChannelSource>& beauty, const PathStrings& words,
                                     Reader reader) {
    std::optional<std::string> best;
    std::optional<Error> failure;
    for (const PathStrings& world : worlds_around(words)) {
        auto left = guarded([&] { return left_over(channels, beauty, world, reader); });
        if (!left) {
            failure = left.error();  // a different W can give a smaller automaton
            continue;
        }
        std::optional<std::string> text = std::move(*left);
        if (!text || (best && best->size() <= text->size())) { continue; }
        std::vector<ChannelSource> whole(channels.begin(), channels.end());
        whole.push_back(printed(*text));
        const Result<PartitionReport> proof = check_partition(whole, beauty, words);
        if (proof && proof->result == SplitProof::partition) { best = std::move(text); }
    }
    if (!best && failure) { throw Failure{std::move(*failure)}; }
    return best;
}

}  // namespace

Result<std::optional<std::string>> rest_expression(std::span<const ChannelSource> channels,
                                                   const std::optional<ChannelSource>& beauty, const PathStrings& words,
                                                   Reader reader) {
    return guarded([&] { return rest_text(channels, beauty, words, reader); });
}

Result<std::optional<std::string>> plain_expression(const ChannelSource& channel, const PathStrings& words) {
    return guarded([&]() -> std::optional<std::string> {
        const PrintingQuestion question = pose_for_printing({&channel, 1}, words);
        const auto cut = product(*question.languages.words, question.languages.channels[0], intersection_of(),
                                 limits::boolean_states);
        if (!cut || question.labels.deeper) { return std::nullopt; }
        std::optional<std::string> text = text_of(minimized(*cut), question.languages, question.labels);
        if (!text) { return std::nullopt; }
        const auto difference = find_difference(channel, printed(*text), words);
        return difference && !difference->has_value() ? text : std::nullopt;
    });
}

}  // namespace raylex::lpe
