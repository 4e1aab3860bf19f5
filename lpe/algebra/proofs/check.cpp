#include "lpe/algebra/proofs/check.h"

#include <algorithm>
#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/failure.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// An automaton that counts accepting channels, of the first `count`, for each word of W: output 1 for none, 2 for one,
/// 3 for two or more.
Dfa counted(const Languages& languages, std::size_t count) {
    std::vector<Dfa> cut;
    cut.reserve(count);
    std::vector<const Dfa*> members;
    for (std::size_t k = 0; k < count; ++k) {
        cut.push_back(intersection(*languages.words, languages.channels[k]));
        members.push_back(&cut.back());
    }
    const Dfa total =
        joined(members, count_of(), limits::boolean_states, languages.classes->count(), "the channels of this proof");
    const auto within = [](void* /*context*/, std::uint32_t word, std::uint32_t n) { return word != 0 ? n + 1 : 0; };
    return required(product(*languages.words, total, {within, nullptr, false, true}, limits::boolean_states));
}

constexpr std::uint32_t missed_code = 1, twice_code = 2, outside_code = 3;

std::uint32_t violation(std::uint32_t counted_output, bool in_beauty) {
    if (counted_output == 0) { return 0; }
    const std::uint32_t channels = counted_output - 1;
    if (in_beauty) { return channels == 0 ? missed_code : channels == 1 ? 0 : twice_code; }
    return channels == 0 ? 0 : outside_code;
}

PartitionReport partition_report(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
                                 const PathStrings& words) {
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    if (beauty) { all.push_back(*beauty); }
    Question question = pose(all, words, "a partition");
    const Languages& languages = question.languages;
    const auto run_checks = [](void* /*context*/, std::uint32_t n, std::uint32_t b) { return violation(n, b != 0); };
    const Dfa total = counted(languages, channels.size());
    const Dfa& whole = beauty ? languages.channels.back() : *languages.words;
    const Dfa violations = required(product(total, whole, {run_checks, nullptr, false, true}, limits::boolean_states));
    PartitionReport report;
    report.warnings = std::move(question.warnings);
    const auto word = shortest_path_string(violations, is_set);
    const bool all_of_it =
        !beauty || !shortest_path_string(difference(*languages.words, languages.channels.back()), is_set);
    const std::string of = !beauty ? "the beauty" : "'" + beauty->expression + "'" + (all_of_it ? ", the beauty" : "");
    if (!word) {
        report.summary = std::to_string(channels.size()) + (channels.size() == 1 ? " channel is" : " channels are") +
                         " a partition of " + of + ": every path is counted exactly once";
        return report;
    }
    report.witness = witness_of(*word, *languages.classes);
    report.channels = accepting(languages.channels, channels.size(), *word);
    std::uint32_t state = violations.start;
    for (const EventClass event_class : *word) { state = violations.step(state, event_class); }
    switch (violations.output[state]) {
        case missed_code:
            report.result = SplitProof::missed;
            report.summary = "no channel counts " + in_words(report.witness);
            break;
        case twice_code:
            report.result = SplitProof::counted_twice;
            report.summary = name_list(channels, report.channels) + " all count " + in_words(report.witness);
            if (report.channels.size() == 2) {
                report.summary = name_list(channels, report.channels) + " both count " + in_words(report.witness);
            }
            break;
        default:
            report.result = SplitProof::outside;
            report.summary = name_list(channels, report.channels) +
                             (report.channels.size() == 1 ? " counts " : " count ") + in_words(report.witness) +
                             ", which " + of + " does not contain";
    }
    return report;
}

DisjointReport disjoint_report(std::span<const ChannelSource> channels, const PathStrings& words) {
    Question question = pose(channels, words, "a partition");
    DisjointReport report;
    report.warnings = std::move(question.warnings);
    const Dfa total = counted(question.languages, channels.size());
    const auto word = shortest_path_string(total, [](std::uint32_t output) { return output == 3; });
    if (!word) {
        report.summary = "no path is counted by two of these channels";
        return report;
    }
    report.disjoint = false;
    report.witness = witness_of(*word, *question.languages.classes);
    report.channels = accepting(question.languages.channels, channels.size(), *word);
    report.summary = name_list(channels, report.channels) +
                     (report.channels.size() == 2 ? " both count " : " all count ") + in_words(report.witness);
    return report;
}

}  // namespace

Result<PartitionReport> check_partition(std::span<const ChannelSource> channels,
                                        const std::optional<ChannelSource>& beauty, const PathStrings& words) {
    return guarded([&] { return partition_report(channels, beauty, words); });
}

Result<DisjointReport> check_disjoint(std::span<const ChannelSource> channels, const PathStrings& words) {
    return guarded([&] { return disjoint_report(channels, words); });
}

Result<std::optional<Witness>> find_difference(const ChannelSource& a, const ChannelSource& b,
                                               const PathStrings& words) {
    return guarded([&]() -> std::optional<Witness> {
        const std::vector<ChannelSource> both{a, b};
        const Question question = pose(both, words, nullptr);
        const Languages& languages = question.languages;
        const Dfa different = symmetric_difference(languages.channels[0], languages.channels[1], *languages.words);
        const auto word = shortest_path_string(different, is_set);
        return word ? std::optional<Witness>(witness_of(*word, *languages.classes)) : std::nullopt;
    });
}

Result<std::optional<Witness>> find_path_string(const ChannelSource& channel, const PathStrings& words) {
    return guarded([&]() -> std::optional<Witness> {
        const Question question = pose({&channel, 1}, words, nullptr);
        const Languages& languages = question.languages;
        const Dfa inside = intersection(*languages.words, languages.channels[0]);
        const auto word = shortest_path_string(inside, is_set);
        return word ? std::optional<Witness>(witness_of(*word, *languages.classes)) : std::nullopt;
    });
}

Result<std::vector<std::string>> expression_prefixes(const ChannelSource& channel) {
    return guarded([&] { return parse(channel).prefixes; });
}

Result<std::string> why_no_part(const ChannelSource& channel) {
    return guarded([&] { return what_bars(parse(channel)); });
}

Result<std::vector<std::string>> expression_warnings(const ChannelSource& channel, const PathStrings& words) {
    return guarded([&] {
        const Expression expression = parse(channel);
        std::vector<std::string> warnings = expression.warnings;
        warn_about_bar(channel, expression, words, warnings);
        return warnings;
    });
}

}  // namespace raylex::lpe
