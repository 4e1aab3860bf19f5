// What every proof starts from: channels read, made into automata over common event classes, W beside them.
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
    std::vector<Expression> expressions;  ///< one per channel; no tree for those with rest_of
    std::vector<std::string> warnings;
};

/// Reads the channels. `refuse_others_in`: what channels that take other than light of W (with prefixes, with user
/// events) cannot take part in ("a partition"), or null.
/// `telling_letters`: no event class holds events of different type or scattering, so that words of classes are words
/// of letters. Throws Failure.
[[nodiscard]] Question pose(std::span<const ChannelSource> channels, const Words& words, const char* refuse_others_in,
                            bool telling_letters = false);

/// Whether some event of the tree is a user event.
[[nodiscard]] bool names_user_events(const Node& node);
/// See why_no_part().
[[nodiscard]] std::string what_bars(const Expression& expression);

/// One event for every type and scattering there is: beside other expressions, it keeps their event classes apart so.
[[nodiscard]] Expression letters();

/// W for looking at these channels: straight-through events are left out where no channel has them as letters.
[[nodiscard]] Words words_for(std::span<const ChannelSource> channels, Words words);

[[nodiscard]] Witness witness_of(const std::vector<EventClass>& word, const EventClasses& classes);
/// The first `count` automata that accept the word.
[[nodiscard]] std::vector<std::size_t> accepting(const std::vector<Dfa>& dfas, std::size_t count,
                                                 const std::vector<EventClass>& word);

/// "'a'", "'a' and 'b'", "'a', 'b' and 'c'"
[[nodiscard]] std::string name_list(std::span<const ChannelSource> channels, const std::vector<std::size_t>& which);
/// The channel's name in quotes, or its expression, marked 'osl:' where it is of that dialect.
[[nodiscard]] std::string name_of(const ChannelSource& channel);
/// "camera, light (C,- L,-)"
[[nodiscard]] std::string in_words(const Witness& witness);

/// A product's automaton, minimised; throws Failure when the product was too large.
[[nodiscard]] Dfa required(std::optional<Dfa> dfa);
[[nodiscard]] Dfa intersection(const Dfa& a, const Dfa& b);
[[nodiscard]] Dfa difference(const Dfa& a, const Dfa& b);
/// The words of `words` on which exactly one of the two automata accepts.
[[nodiscard]] Dfa symmetric_difference(const Dfa& a, const Dfa& b, const Dfa& words);

[[nodiscard]] inline bool is_set(std::uint32_t output) {
    return output != 0;
}

/// Adds a warning when `expression` would mean something else with '|' looser than concatenation.
void warn_about_bar(const ChannelSource& source, const Expression& expression, const Words& words,
                    std::vector<std::string>& warnings);

}  // namespace raylex::lpe
