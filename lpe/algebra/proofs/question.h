// The common start of every proof: parsed channels, compiled to automata over common event classes, together with W.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/automata/languages.h"
#include "lpe/language/ast.h"

namespace raylex::lpe {

struct Question {
    Languages languages;
    std::vector<Expression> expressions;  ///< one per channel; the tree is null for channels with rest_of
    std::vector<std::string> warnings;
};

/// Parses and compiles the channels. `refuse_others_in`: name of the proof ("a partition") that channels with prefixes
/// or user events cannot take part in, or null to accept them. `telling_letters`: no event class contains events of
/// different type or scattering, so that words of classes are words of letters. Throws Failure.
[[nodiscard]] Question pose(std::span<const ChannelSource> channels, const PathStrings& words,
                            const char* refuse_others_in, bool telling_letters = false);

/// Returns whether the tree contains a user event.
[[nodiscard]] bool names_user_events(const Node& node);
/// Why the expression cannot take part in a split; see why_no_part().
[[nodiscard]] std::string what_bars(const Expression& expression);

/// A tree with one event for every type and scattering. Compiling it with other expressions keeps their event classes
/// separate by type and scattering.
[[nodiscard]] Expression letters();

/// W for these channels: without pass-through events where no channel uses them as letters.
[[nodiscard]] PathStrings path_strings_for(std::span<const ChannelSource> channels, PathStrings words);

[[nodiscard]] Witness witness_of(const std::vector<EventClass>& word, const EventClasses& classes);
/// The indices of those of the first `count` automata that accept the word.
[[nodiscard]] std::vector<std::size_t> accepting(const std::vector<Dfa>& dfas, std::size_t count,
                                                 const std::vector<EventClass>& word);

/// "'a'", "'a' and 'b'", "'a', 'b' and 'c'"
[[nodiscard]] std::string name_list(std::span<const ChannelSource> channels, const std::vector<std::size_t>& which);
/// The channel's name in quotes, or its expression; an osl expression gets the prefix 'osl:'.
[[nodiscard]] std::string name_of(const ChannelSource& channel);
/// "camera, light (C,- L,-)"
[[nodiscard]] std::string in_words(const Witness& witness);

/// The automaton of a product, minimised. Throws Failure when the product was too large.
[[nodiscard]] Dfa required(std::optional<Dfa> dfa);
[[nodiscard]] Dfa intersection(const Dfa& a, const Dfa& b);
[[nodiscard]] Dfa difference(const Dfa& a, const Dfa& b);
/// The words of `words` on which exactly one of the two automata accepts.
[[nodiscard]] Dfa symmetric_difference(const Dfa& a, const Dfa& b, const Dfa& words);

[[nodiscard]] inline bool is_set(std::uint32_t output) {
    return output != 0;
}

/// Adds a warning if giving '|' lower precedence than concatenation changes the meaning of `expression`.
void warn_about_bar(const ChannelSource& source, const Expression& expression, const PathStrings& words,
                    std::vector<std::string>& warnings);

}  // namespace raylex::lpe
