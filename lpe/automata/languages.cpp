#include "lpe/automata/languages.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "lpe/automata/nfa.h"
#include "lpe/failure.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// The distinct event sets of all channels.
class SetTable {
  public:
    std::size_t add(EventSet set) {
        const auto [place, fresh] = index_.emplace(set.key(), sets_.size());
        if (fresh) { sets_.push_back(std::move(set)); }
        return place->second;
    }
    void add_tree(Node& node) {
        if (node.kind == NodeKind::event) { node.event_set = add(node.events); }
        for (const NodePtr& child : node.children) { add_tree(*child); }
    }
    [[nodiscard]] const std::vector<EventSet>& sets() const { return sets_; }
    [[nodiscard]] std::vector<EventSet> take() { return std::move(sets_); }

  private:
    std::vector<EventSet> sets_;
    std::unordered_map<std::string, std::size_t> index_;
};

EventSet set_of_cores(const CoreSet& cores) {
    return {{{cores, {}, Missing::is_empty, Extra::ignored}}, {}};
}

NodePtr any_number_of(EventSet events) {
    NodePtr repeat = make_node(NodeKind::repeat);
    repeat->max = Node::unbounded;
    repeat->children.push_back(make_event(std::move(events)));
    return repeat;
}

/// C scatter* (L | O | B); with at most n scatterings C s* (scatter s*){0,n} (L | O | B), where s is a pass-through
/// event.
NodePtr path_strings_tree(PathStringSets sets) {
    NodePtr tree = make_node(NodeKind::sequence);
    tree->children.push_back(make_event(std::move(sets.camera)));
    if (!sets.max_depth) {
        tree->children.push_back(any_number_of(std::move(sets.scattering)));
    } else {
        NodePtr one = make_node(NodeKind::sequence);
        one->children.push_back(make_event(std::move(sets.scattering)));
        one->children.push_back(any_number_of(sets.straight));
        NodePtr several = make_node(NodeKind::repeat);
        several->max = *sets.max_depth;
        several->children.push_back(std::move(one));
        tree->children.push_back(any_number_of(std::move(sets.straight)));
        tree->children.push_back(std::move(several));
    }
    tree->children.push_back(make_event(std::move(sets.terminal)));
    return tree;
}

/// In renderman words pass-through events leave no event, so every state loops on them.
void ignore_straight_events(Dfa& dfa, const ClassSet& straight) {
    const auto loop = static_cast<std::uint16_t>(dfa.columns);
    for (std::size_t k = 0; k < straight.size(); ++k) {
        if (straight[k]) { dfa.column_of_class[k] = loop; }
    }
    std::vector<std::uint32_t> next;
    next.reserve(dfa.states() * (dfa.columns + 1));
    for (std::uint32_t state = 0; state < dfa.states(); ++state) {
        const auto row = dfa.next.begin() + static_cast<std::ptrdiff_t>(state * dfa.columns);
        next.insert(next.end(), row, row + static_cast<std::ptrdiff_t>(dfa.columns));
        next.push_back(state);
    }
    dfa.next = std::move(next);
    ++dfa.columns;
    // Columns can now be unused. A product would keep them; minimisation removes them.
}

Dfa build_rest(const ChannelSource& rest, std::span<const ChannelSource> channels, const Languages& languages,
               std::size_t state_cap) {
    std::vector<const Dfa*> members;
    for (const std::size_t k : rest.rest_of) {
        if (k >= channels.size() || !channels[k].rest_of.empty()) {
            fail("a rest channel can only be the rest of channels that have an expression");
        }
        members.push_back(&languages.channels[k]);
    }
    const Dfa covered = joined(members, union_of(), state_cap, languages.classes->count(),
                               "the channels that '" + rest.name + "' is the rest of");
    const std::optional<Dfa> remainder = product(*languages.words, covered, difference_of(), state_cap);
    if (!remainder) {
        fail("the rest of these channels needs more than " + std::to_string(state_cap) + " states",
             "make the rest of fewer channels");
    }
    return minimized(*remainder);
}

}  // namespace

Dfa joined(std::span<const Dfa* const> dfas, const Combination& combination, std::size_t state_cap,
           std::size_t class_count, const std::string& what) {
    if (dfas.empty()) { return empty_dfa(class_count); }
    if (dfas.size() == 1) { return *dfas.front(); }
    const Dfa left = joined(dfas.first(dfas.size() / 2), combination, state_cap, class_count, what);
    const Dfa right = joined(dfas.subspan(dfas.size() / 2), combination, state_cap, class_count, what);
    const std::optional<Dfa> both = product(left, right, combination, state_cap);
    if (!both) {
        fail(what + " together need more than " + std::to_string(state_cap) + " states", "use fewer of them at a time");
    }
    return minimized(*both);
}

namespace {

/// Common inputs for building each channel.
struct ChannelBuild {
    const EventClasses& classes;
    const ClassSet &straight, &renderman, &osl;  ///< members of the classes' sets
    const Dfa* renderer_path_strings;            ///< restrict channels to these words; nullptr: no restriction
    std::size_t state_cap;
};

Dfa build_channel(const Expression& expression, const ChannelBuild& build) {
    const bool renderman = expression.dialect == Dialect::renderman;
    WorkMeter work;
    Dfa dfa = build_dfa(*expression.root, {&build.classes, renderman ? &build.renderman : &build.osl, &work},
                        build.state_cap);
    if (renderman) { ignore_straight_events(dfa, build.straight); }
    if (build.renderer_path_strings == nullptr) { return dfa; }
    const std::optional<Dfa> cut = product(dfa, *build.renderer_path_strings, intersection_of(), 4 * build.state_cap);
    if (!cut) { fail("the expression needs too large a table", "use smaller repetition counts and fewer labels"); }
    return minimized(*cut);
}

}  // namespace

Languages build_languages(std::span<const ChannelSource> channels, const LanguageOptions& options) {
    std::vector<Expression> expressions;
    expressions.reserve(channels.size());
    for (const ChannelSource& channel : channels) {
        expressions.push_back(channel.rest_of.empty() ? parse(channel, options.bar) : Expression{});
    }
    return build_languages(channels, expressions, options);
}

Languages build_languages(std::span<const ChannelSource> channels, std::span<Expression> expressions,
                          const LanguageOptions& options) {
    const bool has_rest =
        std::any_of(channels.begin(), channels.end(), [](const ChannelSource& c) { return !c.rest_of.empty(); });
    const PathStrings everything;
    const PathStrings* words = options.words != nullptr ? options.words : has_rest ? &everything : nullptr;

    SetTable table;
    for (Expression& expression : expressions) {
        if (expression.root) { table.add_tree(*expression.root); }
    }
    const std::size_t straight_set = table.add(set_of_cores(straight_cores()));
    const std::size_t renderman_set = table.add(set_of_cores(wildcard_cores(Dialect::renderman)));
    const std::size_t osl_set = table.add(set_of_cores(wildcard_cores(Dialect::osl)));
    NodePtr path_strings_root;
    if (words != nullptr) {
        path_strings_root = path_strings_tree(path_string_sets(*words, options.skip_reserved_labels, table.sets()));
        table.add_tree(*path_strings_root);
    }
    NodePtr renderer_root;
    if (options.renderer_path_strings) {
        renderer_root = path_strings_tree(renderer_path_string_sets());
        table.add_tree(*renderer_root);
    }
    Languages languages;
    languages.classes = std::make_unique<EventClasses>(table.take());
    const EventClasses& classes = *languages.classes;
    const auto built_path_strings = [&](const NodePtr& root) {
        WorkMeter work;
        return build_dfa(*root, {&classes, &classes.members(osl_set), &work}, options.state_cap);
    };
    if (path_strings_root) { languages.words = built_path_strings(path_strings_root); }
    const Dfa renderer_path_strings = renderer_root ? built_path_strings(renderer_root) : Dfa{};
    const ChannelBuild build{classes,
                             classes.members(straight_set),
                             classes.members(renderman_set),
                             classes.members(osl_set),
                             renderer_root ? &renderer_path_strings : nullptr,
                             options.state_cap};
    for (std::size_t k = 0; k < channels.size(); ++k) {
        languages.channels.push_back(empty_dfa(classes.count()));
        if (!expressions[k].root) { continue; }
        try {
            languages.channels.back() = build_channel(expressions[k], build);
        } catch (Failure& failure) { throw Failure{SourceText::whole_error(channels[k], std::move(failure.error))}; }
    }
    for (std::size_t k = 0; k < channels.size(); ++k) {
        if (!channels[k].rest_of.empty()) {
            try {
                languages.channels[k] = build_rest(channels[k], channels, languages, options.state_cap);
            } catch (Failure& failure) {
                throw Failure{SourceText::whole_error(channels[k], std::move(failure.error))};
            }
        }
    }
    return languages;
}

}  // namespace raylex::lpe
