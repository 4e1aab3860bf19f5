#include "lpe/algebra/explanation/explain_study.h"

#include <algorithm>
#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/failure.h"
#include "lpe/language/names.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"
#include "lpe/shipped.h"

namespace raylex::lpe {

namespace {

NodePtr any_number_of(EventSet events) {
    NodePtr node = make_node(NodeKind::repeat);
    node->max = Node::unbounded;
    node->children.push_back(make_event(std::move(events)));
    return node;
}

/// W extended by user events among the scattering events. The depth limit is dropped: user events do not count towards
/// it, and this set is used for explanations, not for proofs.
Expression path_strings_with_users(PathStrings words) {
    words.max_depth.reset();
    PathStringSets sets = path_string_sets(words, false);
    EventPattern users{{}, {}, Missing::is_empty, Extra::ignored};
    for (std::size_t core = core_count - user_numbers; core < core_count; ++core) { users.cores.set(core); }
    sets.scattering.any_of.push_back(std::move(users));
    Expression expression;
    expression.dialect = Dialect::osl;
    expression.root = make_node(NodeKind::sequence);
    expression.root->children.push_back(make_event(std::move(sets.camera)));
    expression.root->children.push_back(any_number_of(std::move(sets.scattering)));
    expression.root->children.push_back(make_event(std::move(sets.terminal)));
    return expression;
}

/// Compiles the channels and W; `users`: W also contains user events.
Languages with_path_strings(std::vector<ChannelSource>& sources, std::vector<Expression>& expressions,
                            const PathStrings& words, bool users, bool osl) {
    LanguageOptions options;
    options.words = &words;
    options.skip_reserved_labels = osl;
    if (users) {
        sources.emplace_back();
        expressions.push_back(path_strings_with_users(words));
    }
    Languages languages = build_languages(sources, expressions, options);
    if (users) {
        languages.words = std::move(languages.channels.back());
        languages.channels.pop_back();
        expressions.pop_back();
        sources.pop_back();
    }
    return languages;
}

bool has_path_string(const Dfa& dfa) {
    return shortest_path_string(dfa, is_set).has_value();
}

struct Known {
    std::string words;  // "the shipped channel 'volume'"
    ChannelSource source;
};

std::vector<Known> known_channels(Dialect dialect) {
    std::vector<Known> known;
    for (const NamedExpression& shipped : shipped_partition(dialect)) {
        known.push_back({"the shipped channel '" + std::string(shipped.name) + "'", {}});
        known.back().source.expression = std::string(shipped.expression);
        known.back().source.dialect = dialect;
    }
    for (const NamedExpression& name : builtin_names()) {
        known.push_back({"RenderMan's '" + std::string(name.name) + "'", {}});
        known.back().source.expression = std::string(name.expression);
    }
    return known;
}

std::string without_words(Feature feature) {
    switch (feature) {
        case Feature::volume:
            return "no medium";
        case Feature::background:
            return "no background";
        case Feature::emission:
            return "no emission";
        default:
            return "no cutout";
    }
}

/// The smallest set of features whose absence leaves no word in `difference`, that is, makes two expressions equal;
/// nothing if that needs more than `most` features.
std::optional<std::vector<Feature>> excused_by(const Dfa& difference_words, const Study& study, std::size_t most) {
    std::optional<std::vector<Feature>> best;
    for (unsigned chosen = 0; chosen < 16; ++chosen) {
        std::vector<Feature> features;
        bool possible = true;
        for (std::size_t k = 0; k < optional_features.size(); ++k) {
            if ((chosen >> k & 1U) != 0) {
                features.push_back(optional_features[k]);
                possible = possible && study.occurs(features.back());
            }
        }
        if (!possible || features.size() > most || (best && best->size() <= features.size())) { continue; }
        Dfa left = difference_words;
        Dfa shared = study.paths;
        for (const Feature feature : features) {
            left = difference(left, study.feature(feature));
            shared = difference(shared, study.feature(feature));
        }
        // Equality is meaningless if the scene without these features leaves the channel no path.
        if (!has_path_string(left) && has_path_string(shared)) { best = std::move(features); }
    }
    return best;
}

std::string where(const std::vector<Feature>& missing) {
    std::vector<std::string> items;
    for (const Feature feature : missing) { items.push_back(without_words(feature)); }
    return items.empty() ? "" : " where there is " + joined_by(items, " and ");
}

}  // namespace

bool Study::accepts_some(Feature which) const {
    return has_path_string(intersection(paths, feature(which)));
}
bool Study::occurs(Feature which) const {
    return has_path_string(intersection(all, feature(which)));
}

Study study(const ChannelSource& channel, const PathStrings& words) {
    Study study;
    Result<Expansion> expansion = expand_names(channel);
    if (!expansion) { throw Failure{std::move(expansion).error()}; }
    study.source = std::move(expansion->source);
    study.expression = parse(study.source);
    study.expression.warnings.insert(study.expression.warnings.begin(), expansion->warnings.begin(),
                                     expansion->warnings.end());
    study.words = path_strings_for({&channel, 1}, words);
    study.user_events = names_user_events(*study.expression.root);
    std::vector<ChannelSource> sources{study.source};
    std::vector<Expression> expressions;
    expressions.push_back(std::move(study.expression));
    for (std::size_t k = 0; k < feature_count; ++k) {
        sources.emplace_back();
        expressions.push_back(path_strings_with(static_cast<Feature>(k)));
    }
    sources.emplace_back();
    expressions.push_back(letters());
    study.languages =
        with_path_strings(sources, expressions, study.words, study.user_events, channel.dialect == Dialect::osl);
    study.expression = std::move(expressions.front());
    study.all = *study.languages.words;
    study.paths = intersection(study.all, study.languages.channels.front());
    for (std::size_t k = 0; k < feature_count; ++k) { study.features[k] = std::move(study.languages.channels[k + 1]); }
    return study;
}

std::vector<bool> have_paths(const Study& study, std::vector<NodePtr> trees) {
    std::vector<bool> answers;
    std::vector<ChannelSource> sources;
    std::vector<Expression> expressions;
    for (NodePtr& tree : trees) {
        sources.push_back(study.source);
        sources.back().rest_of.clear();
        expressions.emplace_back();
        expressions.back().dialect = study.source.dialect;
        expressions.back().root = tree ? std::move(tree) : make_node(NodeKind::alternatives);
    }
    const Languages languages =
        with_path_strings(sources, expressions, study.words, study.user_events, study.source.dialect == Dialect::osl);
    for (const Dfa& dfa : languages.channels) {
        answers.push_back(has_path_string(intersection(*languages.words, dfa)));
    }
    return answers;
}

std::vector<std::string> known_equals(const Study& study, bool& is_beauty) {
    std::vector<std::string> sentences;
    const std::string subject = study.expression.prefixes.empty() ? "It is " : "Prefixes apart, it is ";
    const auto beauty = excused_by(difference(study.all, study.paths), study, optional_features.size());
    is_beauty = false;
    if (beauty && !study.user_events) {
        is_beauty = beauty->empty() && study.expression.prefixes.empty();
        sentences.push_back(subject + "the beauty" + where(*beauty) + ".");
        return sentences;
    }
    constexpr std::size_t small = 200;  // states; shipped channels have fewer than ten, so a larger automaton equals
                                        // none of them
    if (study.user_events || study.paths.states() > small) { return sentences; }
    std::vector<Known> known = known_channels(study.source.dialect);
    std::vector<ChannelSource> sources{study.source};
    std::vector<Expression> expressions;
    expressions.push_back(parse(study.source));
    for (const Known& each : known) {
        sources.push_back(each.source);
        expressions.push_back(parse(each.source));
    }
    for (std::size_t k = 0; k < feature_count; ++k) {
        sources.emplace_back();
        expressions.push_back(path_strings_with(static_cast<Feature>(k)));
    }
    Study beside;
    beside.languages =
        with_path_strings(sources, expressions, study.words, false, study.source.dialect == Dialect::osl);
    beside.all = *beside.languages.words;
    beside.paths = intersection(beside.all, beside.languages.channels.front());
    for (std::size_t k = 0; k < feature_count; ++k) {
        beside.features[k] = beside.languages.channels[known.size() + 1 + k];
    }
    for (const std::size_t most : {std::size_t{0}, std::size_t{1}}) {
        std::vector<std::pair<std::string, std::string>> found;  // where, what
        for (std::size_t k = 0; k < known.size(); ++k) {
            const Dfa differing = symmetric_difference(beside.paths, beside.languages.channels[k + 1], beside.all);
            const auto missing = excused_by(differing, beside, most);
            if (missing && missing->size() == most) { found.emplace_back(where(*missing), known[k].words); }
        }
        for (const auto& [place, what] : found) { sentences.push_back(subject + what + place + "."); }
        if (!found.empty()) {
            break;  // an exact equality makes the conditional ones noise
        }
    }
    return sentences;
}

}  // namespace raylex::lpe
