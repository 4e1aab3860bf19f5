#include "lpe/algebra/proofs/relations.h"

#include <functional>
#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// Builds the proof that `against` is empty. `holds` and `fails` give the summary for the two outcomes.
Proof proof_of(Question& question, std::span<const ChannelSource> channels, const Dfa& against, std::string holds,
               const std::function<std::string(const Proof&)>& fails) {
    Proof proof;
    proof.warnings = std::move(question.warnings);
    const auto word = shortest_path_string(against, is_set);
    if (!word) {
        proof.summary = std::move(holds);
        return proof;
    }
    proof.holds = false;
    proof.witness = witness_of(*word, *question.languages.classes);
    proof.channels = accepting(question.languages.channels, channels.size(), *word);
    proof.summary = fails(proof);
    return proof;
}

std::string all_names(std::span<const ChannelSource> channels) {
    std::vector<std::size_t> which;
    for (std::size_t k = 0; k < channels.size(); ++k) { which.push_back(k); }
    return name_list(channels, which);
}

Proof covers(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
             const PathStrings& words) {
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    if (beauty) { all.push_back(*beauty); }
    Question question = pose(all, words, "a coverage");
    const Languages& languages = question.languages;
    std::vector<const Dfa*> members;
    for (std::size_t k = 0; k < channels.size(); ++k) { members.push_back(&languages.channels[k]); }
    const Dfa any =
        joined(members, union_of(), limits::boolean_states, languages.classes->count(), "the channels of this proof");
    const Dfa whole = beauty ? intersection(*languages.words, languages.channels.back()) : *languages.words;
    const std::string of = beauty ? "'" + beauty->expression + "'" : "the beauty";
    return proof_of(question, channels, difference(whole, any), "every path of " + of + " is counted by some channel",
                    [&](const Proof& proof) { return "no channel counts " + in_words(proof.witness); });
}

Proof equal(std::span<const ChannelSource> channels, const PathStrings& words) {
    Question question = pose(channels, words, nullptr);
    const Languages& languages = question.languages;
    Dfa differing = empty_dfa(languages.classes->count());
    for (std::size_t k = 1; k < channels.size(); ++k) {
        const Dfa one = symmetric_difference(languages.channels[k - 1], languages.channels[k], *languages.words);
        differing = required(product(differing, one, union_of(), limits::boolean_states));
    }
    for (std::size_t k = 1; k < channels.size(); ++k) {
        if (question.expressions[k].prefixes != question.expressions[0].prefixes) {
            question.warnings.push_back(name_of(channels[0]) + " and " + name_of(channels[k]) +
                                        " carry different prefixes: the same paths do not make the same image");
        }
    }
    return proof_of(question, channels, differing, all_names(channels) + " accept the same paths",
                    [&](const Proof& proof) {
                        std::vector<std::size_t> others;
                        std::size_t next = 0;
                        for (std::size_t k = 0; k < channels.size(); ++k) {
                            const bool accepts = next < proof.channels.size() && proof.channels[next] == k;
                            next += accepts ? 1 : 0;
                            if (!accepts) { others.push_back(k); }
                        }
                        return name_list(channels, proof.channels) +
                               (proof.channels.size() == 1 ? " accepts " : " accept ") + in_words(proof.witness) +
                               ", " + name_list(channels, others) + (others.size() == 1 ? " does not" : " do not");
                    });
}

}  // namespace

Result<Proof> check_covers(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
                           const PathStrings& words) {
    return guarded([&] { return covers(channels, beauty, words); });
}

Result<Proof> check_equal(std::span<const ChannelSource> channels, const PathStrings& words) {
    return guarded([&] { return equal(channels, words); });
}

Result<Proof> check_contains(const ChannelSource& outer, const ChannelSource& inner, const PathStrings& words) {
    return guarded([&] {
        const std::vector<ChannelSource> both{outer, inner};
        Question question = pose(both, words, nullptr);
        const Languages& languages = question.languages;
        const Dfa inside = intersection(*languages.words, languages.channels[1]);
        return proof_of(question, both, difference(inside, languages.channels[0]),
                        name_of(outer) + " accepts every path of " + name_of(inner), [&](const Proof& proof) {
                            return name_of(inner) + " accepts " + in_words(proof.witness) + ", " + name_of(outer) +
                                   " does not";
                        });
    });
}

Result<Proof> check_empty(const ChannelSource& channel, const PathStrings& words) {
    return guarded([&] {
        const std::span<const ChannelSource> one{&channel, 1};
        Question question = pose(one, words, nullptr);
        const Languages& languages = question.languages;
        const Dfa inside = intersection(*languages.words, languages.channels[0]);
        return proof_of(question, one, inside, name_of(channel) + " accepts no path",
                        [&](const Proof& proof) { return name_of(channel) + " accepts " + in_words(proof.witness); });
    });
}

Result<bool> is_beauty(const ChannelSource& expression, const PathStrings& words) {
    return guarded([&] {
        const Question question = pose({&expression, 1}, words, nullptr);
        if (!question.expressions[0].prefixes.empty()) { return false; }
        const Dfa missing = difference(*question.languages.words, question.languages.channels[0]);
        return !shortest_path_string(missing, is_set).has_value();
    });
}

}  // namespace raylex::lpe
