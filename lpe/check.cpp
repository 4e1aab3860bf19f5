#include "lpe/check.h"

#include <algorithm>
#include <utility>

#include "lpe/failure.h"
#include "lpe/languages.h"
#include "lpe/limits.h"
#include "lpe/match.h"
#include "lpe/parser.h"

namespace raylex::lpe {

namespace {

Witness witness_of(const std::vector<EventClass>& word, const EventClasses& classes) {
    Witness witness;
    for (const EventClass event_class : word) {
        witness.events.push_back(classes.example(event_class));
    }
    witness.text = to_text(witness.events);
    witness.sentence = to_sentence(witness.events);
    return witness;
}

std::vector<std::size_t> accepting(const std::vector<Dfa>& dfas, std::size_t count, const std::vector<EventClass>& word) {
    std::vector<std::size_t> channels;
    for (std::size_t k = 0; k < count; ++k) {
        std::uint32_t state = dfas[k].start;
        for (const EventClass event_class : word) {
            state = dfas[k].step(state, event_class);
        }
        if (dfas[k].output[state] != 0) {
            channels.push_back(k);
        }
    }
    return channels;
}

/// "'a'", "'a' and 'b'", "'a', 'b' and 'c'"
std::string name_list(std::span<const ChannelSource> channels, const std::vector<std::size_t>& which) {
    std::string text;
    for (std::size_t i = 0; i < which.size(); ++i) {
        text += i == 0 ? "" : i + 1 == which.size() ? " and " : ", ";
        text += '\'';
        text += channels[which[i]].name.empty() ? channels[which[i]].expression : channels[which[i]].name;
        text += '\'';
    }
    return text;
}

std::string in_words(const Witness& witness) { return witness.sentence + " (" + witness.text + ")"; }

Dfa required(std::optional<Dfa> dfa) {
    if (!dfa) {
        fail("the proof needs more than " + std::to_string(limits::boolean_states) + " states", "check fewer channels at a time");
    }
    return minimized(*dfa);
}

/// The paths of W on which exactly one of the two automata accepts.
Dfa symmetric_difference(const Dfa& a, const Dfa& b, const Dfa& words) {
    const auto differ = [](void* /*context*/, std::uint32_t x, std::uint32_t y) { return x ^ y; };
    const Dfa both = required(product(a, b, {differ, nullptr, false, false}, limits::boolean_states));
    return required(product(words, both, intersection_of(), limits::boolean_states));
}

bool is_set(std::uint32_t output) { return output != 0; }

/// A warning when `expression` would mean something else with '|' looser than concatenation.
void warn_about_bar(const ChannelSource& source, const Expression& expression, const Words& words,
                    std::vector<std::string>& warnings) {
    if (!expression.has_bar) {
        return;
    }
    std::vector<Expression> readings;
    readings.push_back(parse(source, BarReading::tight));
    readings.push_back(parse(source, BarReading::loose));
    const std::vector<ChannelSource> sources{source, source};
    LanguageOptions options;
    options.words = &words;
    options.skip_reserved_labels = source.dialect == Dialect::osl;
    const Languages languages = build_languages(sources, readings, options);
    const Dfa different = symmetric_difference(languages.channels[0], languages.channels[1], *languages.words);
    const auto word = shortest_word(different, is_set);
    if (!word) {
        return;
    }
    const Witness witness = witness_of(*word, *languages.classes);
    const bool tight_accepts = !accepting(languages.channels, 1, *word).empty();
    std::string warning = source.name.empty() ? "'|'" : "channel '" + source.name + "': '|'";
    warning += " joins only the events beside it, as in CD|SL = C(D|S)L; read as looser than concatenation the expression would ";
    warning += tight_accepts ? "not match " : "also match ";
    warning += in_words(witness);
    warnings.push_back(std::move(warning));
}

/// The channels of a question, read and made into automata, W beside them.
struct Question {
    Languages languages;
    std::vector<std::string> warnings;
};

Question pose(std::span<const ChannelSource> channels, const Words& words, const char* refuse_prefixes_in) {
    Question question;
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
        Expression& expression = expressions.back();
        if (refuse_prefixes_in != nullptr && !expression.prefixes.empty()) {
            Error error;
            error.message = "the expression carries the prefix '" + expression.prefixes.front() +
                            "', which changes what is splatted; channels with prefixes cannot take part in " + refuse_prefixes_in;
            error.hint = "leave the prefix out of the check, or the channel out of the set";
            throw Failure{SourceText::whole_error(channel, std::move(error))};
        }
        for (const std::string& warning : expression.warnings) {
            question.warnings.push_back(channel.name.empty() ? warning : "channel '" + channel.name + "': " + warning);
        }
        warn_about_bar(channel, expression, words, question.warnings);
    }
    question.languages = build_languages(channels, expressions, options);
    return question;
}

/// How many of the first `count` channels accept each word of W: output 1 for none, 2 for one, 3 for two or more.
Dfa counted(const Languages& languages, std::size_t count) {
    std::vector<Dfa> cut;
    cut.reserve(count);
    std::vector<const Dfa*> members;
    for (std::size_t k = 0; k < count; ++k) {
        cut.push_back(required(product(*languages.words, languages.channels[k], intersection_of(), limits::boolean_states)));
        members.push_back(&cut.back());
    }
    const Dfa total = joined(members, count_of(), limits::boolean_states, languages.classes->count(), "the channels of this proof");
    const auto within = [](void* /*context*/, std::uint32_t word, std::uint32_t n) { return word != 0 ? n + 1 : 0; };
    return required(product(*languages.words, total, {within, nullptr, false, true}, limits::boolean_states));
}

constexpr std::uint32_t missed_code = 1, twice_code = 2, outside_code = 3;

std::uint32_t violation(std::uint32_t counted_output, bool in_beauty) {
    if (counted_output == 0) {
        return 0;
    }
    const std::uint32_t channels = counted_output - 1;
    if (in_beauty) {
        return channels == 0 ? missed_code : channels == 1 ? 0 : twice_code;
    }
    return channels == 0 ? 0 : outside_code;
}

PartitionReport partition_report(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
                                 const Words& words) {
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    if (beauty) {
        all.push_back(*beauty);
    }
    Question question = pose(all, words, "a partition");
    const Languages& languages = question.languages;
    const auto judge = [](void* /*context*/, std::uint32_t n, std::uint32_t b) { return violation(n, b != 0); };
    const Dfa total = counted(languages, channels.size());
    const Dfa& whole = beauty ? languages.channels.back() : *languages.words;
    const Dfa violations = required(product(total, whole, {judge, nullptr, false, true}, limits::boolean_states));
    PartitionReport report;
    report.warnings = std::move(question.warnings);
    const auto word = shortest_word(violations, is_set);
    const std::string of = beauty ? "'" + beauty->expression + "'" : "the beauty";
    if (!word) {
        report.summary = std::to_string(channels.size()) + (channels.size() == 1 ? " channel is" : " channels are") +
                         " a partition of " + of + ": every path is counted exactly once";
        return report;
    }
    report.witness = witness_of(*word, *languages.classes);
    report.channels = accepting(languages.channels, channels.size(), *word);
    std::uint32_t state = violations.start;
    for (const EventClass event_class : *word) {
        state = violations.step(state, event_class);
    }
    switch (violations.output[state]) {
        case missed_code:
            report.verdict = Verdict::missed;
            report.summary = "no channel counts " + in_words(report.witness);
            break;
        case twice_code:
            report.verdict = Verdict::counted_twice;
            report.summary = name_list(channels, report.channels) + " all count " + in_words(report.witness);
            if (report.channels.size() == 2) {
                report.summary = name_list(channels, report.channels) + " both count " + in_words(report.witness);
            }
            break;
        default:
            report.verdict = Verdict::outside;
            report.summary = name_list(channels, report.channels) + (report.channels.size() == 1 ? " counts " : " count ") +
                             in_words(report.witness) + ", which " + of + " does not contain";
    }
    return report;
}

DisjointReport disjoint_report(std::span<const ChannelSource> channels, const Words& words) {
    Question question = pose(channels, words, "a partition");
    DisjointReport report;
    report.warnings = std::move(question.warnings);
    const Dfa total = counted(question.languages, channels.size());
    const auto word = shortest_word(total, [](std::uint32_t output) { return output == 3; });
    if (!word) {
        report.summary = "no path is counted by two of these channels";
        return report;
    }
    report.disjoint = false;
    report.witness = witness_of(*word, *question.languages.classes);
    report.channels = accepting(question.languages.channels, channels.size(), *word);
    report.summary = name_list(channels, report.channels) + (report.channels.size() == 2 ? " both count " : " all count ") +
                     in_words(report.witness);
    return report;
}

}  // namespace

Result<PartitionReport> check_partition(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
                                        const Words& words) {
    return guarded([&] { return partition_report(channels, beauty, words); });
}

Result<DisjointReport> check_disjoint(std::span<const ChannelSource> channels, const Words& words) {
    return guarded([&] { return disjoint_report(channels, words); });
}

Result<std::optional<Witness>> find_difference(const ChannelSource& a, const ChannelSource& b, const Words& words) {
    return guarded([&]() -> std::optional<Witness> {
        const std::vector<ChannelSource> both{a, b};
        const Question question = pose(both, words, nullptr);
        const Languages& languages = question.languages;
        const Dfa different = symmetric_difference(languages.channels[0], languages.channels[1], *languages.words);
        const auto word = shortest_word(different, is_set);
        return word ? std::optional<Witness>(witness_of(*word, *languages.classes)) : std::nullopt;
    });
}

Result<std::optional<Witness>> find_word(const ChannelSource& channel, const Words& words) {
    return guarded([&]() -> std::optional<Witness> {
        const Question question = pose({&channel, 1}, words, nullptr);
        const Languages& languages = question.languages;
        const Dfa inside = required(product(*languages.words, languages.channels[0], intersection_of(), limits::boolean_states));
        const auto word = shortest_word(inside, is_set);
        return word ? std::optional<Witness>(witness_of(*word, *languages.classes)) : std::nullopt;
    });
}

Result<std::vector<std::string>> expression_prefixes(const ChannelSource& channel) {
    return guarded([&] { return parse(channel).prefixes; });
}

Result<std::vector<std::string>> expression_warnings(const ChannelSource& channel, const Words& words) {
    return guarded([&] {
        const Expression expression = parse(channel);
        std::vector<std::string> warnings = expression.warnings;
        warn_about_bar(channel, expression, words, warnings);
        return warnings;
    });
}

}  // namespace raylex::lpe
