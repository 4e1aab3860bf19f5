#include "lpe/adopt/channel_set.h"

#include <algorithm>
#include <string>
#include <unordered_set>
#include <utility>

#include "lpe/automata/groups.h"
#include "lpe/automata/languages.h"
#include "lpe/automata/layout.h"
#include "lpe/failure.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"

namespace raylex::lpe {

struct ChannelSet::Content {
    CompileOptions options;
    std::vector<ChannelSource> channels;
    std::vector<EventSet> sets;  // the distinct event sets of all channels
    std::unordered_set<std::string> set_keys;
    std::shared_ptr<const EventClasses> classes;
    std::vector<Dfa> leaves;  // [channel] over `classes`
    Grouping grouping;
    std::size_t grouped_states = 0;  // states of all tables after the last full grouping
    std::size_t regroupings = 0;

    bool add_set(const EventSet& set) {
        const bool fresh = set_keys.insert(set.key()).second;
        if (fresh) { sets.push_back(set); }
        return fresh;
    }
    bool add_tree(const Node& node) {
        bool fresh = node.kind == NodeKind::event && add_set(node.events);
        for (const NodePtr& child : node.children) { fresh = add_tree(*child) || fresh; }
        return fresh;
    }
    bool add_fixed_sets() {
        const PathStringSets words = renderer_path_string_sets();
        bool fresh = false;
        for (const CoreSet& cores :
             {straight_cores(), wildcard_cores(Dialect::renderman), wildcard_cores(Dialect::osl)}) {
            fresh = add_set({{{cores, {}, Missing::is_empty, Extra::ignored}}, {}}) || fresh;
        }
        for (const EventSet* set : {&words.camera, &words.scattering, &words.terminal}) {
            fresh = add_set(*set) || fresh;
        }
        return fresh;
    }
};

namespace {

/// Maps each class of `finer` to the class of `coarser` that contains its events.
std::vector<EventClass> class_map(const EventClasses& finer, const EventClasses& coarser) {
    std::vector<EventClass> map;
    for (std::size_t k = 0; k < finer.count(); ++k) {
        map.push_back(coarser.classify(finer.example(static_cast<EventClass>(k))));
    }
    return map;
}

void refine(Dfa& dfa, const std::vector<EventClass>& map) {
    std::vector<std::uint16_t> columns;
    columns.reserve(map.size());
    for (const EventClass old : map) { columns.push_back(dfa.column_of_class[old]); }
    dfa.column_of_class = std::move(columns);
}

std::size_t table_states(const Grouping& grouping) {
    std::size_t states = 0;
    for (const Group& table : grouping.tables) { states += table.dfa.states(); }
    return states;
}

}  // namespace

ChannelSet::ChannelSet(const CompileOptions& options) : content_(std::make_unique<Content>()) {
    content_->options = options;
}
ChannelSet::~ChannelSet() = default;
ChannelSet::ChannelSet(ChannelSet&&) noexcept = default;
ChannelSet& ChannelSet::operator=(ChannelSet&&) noexcept = default;

std::span<const ChannelSource> ChannelSet::channels() const {
    return content_->channels;
}
std::size_t ChannelSet::regroupings() const {
    return content_->regroupings;
}

Result<Program> ChannelSet::add(std::span<const ChannelSource> added) {
    return guarded([&]() -> Program {
        Content next(*content_);
        if (next.channels.size() + added.size() > limits::channels) {
            fail(std::to_string(next.channels.size() + added.size()) + " channels; at most " +
                 std::to_string(limits::channels) + " can be compiled together");
        }
        std::vector<Expression> expressions;
        bool fresh = next.add_fixed_sets();
        for (const ChannelSource& channel : added) {
            if (!channel.rest_of.empty()) {
                fail("channel '" + channel.name +
                     "' uses rest_of; a channel set takes only channels with an expression");
            }
            expressions.push_back(parse(channel));
            fresh = next.add_tree(*expressions.back().root) || fresh;
            next.channels.push_back(channel);
        }
        if (fresh) {
            auto classes = std::make_shared<const EventClasses>(next.sets);
            if (next.classes) {
                const std::vector<EventClass> map = class_map(*classes, *next.classes);
                for (Dfa& leaf : next.leaves) { refine(leaf, map); }
                for (std::vector<Group>* groups : {&next.grouping.tables, &next.grouping.parallel}) {
                    for (Group& group : *groups) { refine(group.dfa, map); }
                }
            }
            next.classes = std::move(classes);
        }

        LanguageOptions language_options;
        language_options.state_cap = std::max(next.options.state_cap, limits::boolean_states);
        language_options.renderer_path_strings = !next.options.any_path_string;
        Languages languages = build_languages(added, expressions, language_options);
        const std::vector<EventClass> map = class_map(*next.classes, *languages.classes);
        const std::vector<ClassRole> roles =
            next.options.any_path_string ? std::vector<ClassRole>{} : roles_of(*next.classes);
        bool fits = !next.leaves.empty();
        for (Dfa& dfa : languages.channels) {
            refine(dfa, map);
            const auto channel = static_cast<std::uint16_t>(next.leaves.size());
            fits = fits && add_channel(next.grouping, {dfa, {{}, {channel}}}, roles, next.options);
            next.leaves.push_back(std::move(dfa));
        }
        if (!fits || table_states(next.grouping) > 2 * next.grouped_states + 256) {
            next.grouping = group_channels(next.leaves, next.channels, roles, next.options);
            next.grouped_states = table_states(next.grouping);
            next.regroupings += content_->leaves.empty() ? 0 : 1;
        }
        Program program(lay_out(*next.classes, next.grouping, next.channels, next.options));
        *content_ = std::move(next);
        return program;
    });
}

}  // namespace raylex::lpe
