// Words of an automaton to look at: varied samples, and how many there are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "lpe/automata/dfa.h"

namespace raylex::lpe {

/// Up to `count` different accepted words: the shortest first, then words a little longer that show events and turns
/// not shown yet. Nothing when the language is empty.
[[nodiscard]] std::vector<std::vector<EventClass>> sample_words(const Dfa& dfa, std::size_t count);

/// How many words of 0, 1, ... `longest` classes are accepted; numbers from most_words on are cut to it.
inline constexpr std::uint64_t most_words = 1'000'000'000'000'000'000;
[[nodiscard]] std::vector<std::uint64_t> count_words(const Dfa& dfa, std::size_t longest);

/// The length of the longest word; nothing when there is no longest, or no word at all.
[[nodiscard]] std::optional<std::size_t> longest_word(const Dfa& dfa);

/// Fewest events to acceptance from each state; `unreachable` where there is no way.
inline constexpr std::uint32_t unreachable = 0xFFFFFFFFU;
[[nodiscard]] std::vector<std::uint32_t> events_to_acceptance(const Dfa& dfa);

}  // namespace raylex::lpe
