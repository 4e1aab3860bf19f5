#include "lpe/algebra/proofs/question.h"

#include <algorithm>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"
#include "lpe/match.h"

namespace raylex::lpe {

Witness witness_of(const std::vector<EventClass>& word, const EventClasses& classes) {
    Witness witness;
    for (const EventClass event_class : word) { witness.events.push_back(classes.example(event_class)); }
    witness.text = to_text(witness.events);
    witness.sentence = to_sentence(witness.events);
    return witness;
}

std::vector<std::size_t> accepting(const std::vector<Dfa>& dfas, std::size_t count,
                                   const std::vector<EventClass>& word) {
    std::vector<std::size_t> channels;
    for (std::size_t k = 0; k < count; ++k) {
        std::uint32_t state = dfas[k].start;
        for (const EventClass event_class : word) { state = dfas[k].step(state, event_class); }
        if (dfas[k].output[state] != 0) { channels.push_back(k); }
    }
    return channels;
}

std::string name_list(std::span<const ChannelSource> channels, const std::vector<std::size_t>& which) {
    std::string text;
    for (std::size_t i = 0; i < which.size(); ++i) {
        text += i == 0 ? "" : i + 1 == which.size() ? " and " : ", ";
        text += name_of(channels[which[i]]);
    }
    return text;
}

std::string name_of(const ChannelSource& channel) {
    if (!channel.name.empty()) { return "'" + channel.name + "'"; }
    return (channel.dialect == Dialect::osl ? "'osl:" : "'") + channel.expression + "'";
}

std::string in_words(const Witness& witness) {
    return witness.sentence + " (" + witness.text + ")";
}

Dfa required(std::optional<Dfa> dfa) {
    if (!dfa) {
        fail("the proof needs more than " + std::to_string(limits::boolean_states) + " states",
             "check fewer channels at a time");
    }
    return minimized(*dfa);
}

Dfa intersection(const Dfa& a, const Dfa& b) {
    return required(product(a, b, intersection_of(), limits::boolean_states));
}

Dfa difference(const Dfa& a, const Dfa& b) {
    return required(product(a, b, difference_of(), limits::boolean_states));
}

Dfa symmetric_difference(const Dfa& a, const Dfa& b, const Dfa& words) {
    const auto differ = [](void* /*context*/, std::uint32_t x, std::uint32_t y) { return x ^ y; };
    const Dfa both = required(product(a, b, {differ, nullptr, false, false}, limits::boolean_states));
    return intersection(words, both);
}

void warn_about_bar(const ChannelSource& source, const Expression& expression, const PathStrings& words,
                    std::vector<std::string>& warnings) {
    if (!expression.has_bar) { return; }
    std::vector<Expression> readings;
    readings.push_back(parse(source, BarReading::tight));
    readings.push_back(parse(source, BarReading::loose));
    const std::vector<ChannelSource> sources{source, source};
    LanguageOptions options;
    options.words = &words;
    options.skip_reserved_labels = source.dialect == Dialect::osl;
    const Languages languages = build_languages(sources, readings, options);
    const Dfa different = symmetric_difference(languages.channels[0], languages.channels[1], *languages.words);
    const auto word = shortest_path_string(different, is_set);
    if (!word) { return; }
    const Witness witness = witness_of(*word, *languages.classes);
    const bool tight_accepts = !accepting(languages.channels, 1, *word).empty();
    std::string warning = source.name.empty() ? "'|'" : "channel '" + source.name + "': '|'";
    warning +=
        " joins only its neighbours, as in CD|SL = C(D|S)L; with '|' looser than concatenation the expression would ";
    warning += tight_accepts ? "not match " : "also match ";
    warning += in_words(witness);
    warnings.push_back(std::move(warning));
}

Expression letters() {
    Expression expression;
    expression.root = make_node(NodeKind::alternatives);
    for (std::size_t core = 0; core < core_count; ++core) {
        const Event event = core_event(core);
        EventSet set{{{{}, {}, Missing::is_empty, Extra::ignored}}, {}};
        for (std::size_t other = 0; other < core_count; ++other) {
            const Event same = core_event(other);
            set.any_of.front().cores[other] = same.type == event.type && same.scatter == event.scatter;
        }
        if (event.lobe_number == 0) { expression.root->children.push_back(make_event(std::move(set))); }
    }
    return expression;
}

PathStrings path_strings_for(std::span<const ChannelSource> channels, PathStrings words) {
    const bool osl =
        std::any_of(channels.begin(), channels.end(), [](const ChannelSource& c) { return c.dialect == Dialect::osl; });
    words.straight = words.straight && osl;
    return words;
}

bool names_user_events(const Node& node) {
    for (const EventPattern& pattern : node.events.any_of) {
        for (std::size_t core = core_count - user_numbers; core < core_count; ++core) {
            if (pattern.cores[core]) { return true; }
        }
    }
    return std::any_of(node.children.begin(), node.children.end(),
                       [](const NodePtr& child) { return names_user_events(*child); });
}

std::string what_bars(const Expression& expression) {
    if (!expression.prefixes.empty()) { return "prefix " + expression.prefixes.front(); }
    return names_user_events(*expression.root) ? "user events" : "";
}

namespace {

[[noreturn]] void throw_barred(const ChannelSource& channel, std::string message, std::string hint) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    throw Failure{SourceText::whole_error(channel, std::move(error))};
}

/// Fails for a channel that counts anything besides the light of the beauty's paths.
void refuse(const ChannelSource& channel, const Expression& expression, const std::string& part) {
    if (!expression.prefixes.empty()) {
        throw_barred(channel,
                     "the expression carries the prefix '" + expression.prefixes.front() +
                         "', which changes the splatted value; channels with prefixes cannot take part in " + part,
                     "leave the prefix out of the check, or the channel out of the set");
    }
    if (names_user_events(*expression.root)) {
        throw_barred(channel,
                     "the expression names user events, which no path of the beauty has; channels with user events "
                     "cannot take part in " +
                         part,
                     "leave the channel out of the set");
    }
}

}  // namespace

Question pose(std::span<const ChannelSource> channels, const PathStrings& words, const char* refuse_others_in,
              bool telling_letters) {
    Question question;
    LanguageOptions options;
    options.words = &words;
    std::vector<Expression>& expressions = question.expressions;
    for (const ChannelSource& channel : channels) {
        if (!channel.rest_of.empty()) {
            expressions.emplace_back();
            continue;
        }
        options.skip_reserved_labels = options.skip_reserved_labels || channel.dialect == Dialect::osl;
        expressions.push_back(parse(channel));
        Expression& expression = expressions.back();
        if (refuse_others_in != nullptr) { refuse(channel, expression, refuse_others_in); }
        for (const std::string& warning : expression.warnings) {
            question.warnings.push_back(channel.name.empty() ? warning : "channel '" + channel.name + "': " + warning);
        }
        warn_about_bar(channel, expression, words, question.warnings);
    }
    if (!telling_letters) {
        question.languages = build_languages(channels, expressions, options);
        return question;
    }
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    all.emplace_back();
    expressions.push_back(letters());
    question.languages = build_languages(all, expressions, options);
    question.languages.channels.pop_back();
    expressions.pop_back();
    return question;
}

}  // namespace raylex::lpe
