// Inspects the words of an automaton: varied samples, and counts by length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "lpe/automata/dfa.h"

namespace raylex::lpe {

/// Returns up to `count` different accepted words: the shortest first, then slightly longer ones that use events and
/// transitions not shown yet. Empty when the language is empty.
[[nodiscard]] std::vector<std::vector<EventClass>> sample_path_strings(const Dfa& dfa, std::size_t count);

/// Numbers of accepted words of 0, 1, ... `longest` classes; each number is clamped to most_words.
inline constexpr std::uint64_t most_words = 1'000'000'000'000'000'000;
[[nodiscard]] std::vector<std::uint64_t> count_path_strings(const Dfa& dfa, std::size_t longest);

/// The length of the longest word; nothing when the language is infinite or empty.
[[nodiscard]] std::optional<std::size_t> longest_path_string(const Dfa& dfa);

/// The fewest events from each state to acceptance; `unreachable` if acceptance cannot be reached.
inline constexpr std::uint32_t unreachable = 0xFFFFFFFFU;
[[nodiscard]] std::vector<std::uint32_t> events_to_acceptance(const Dfa& dfa);

}  // namespace raylex::lpe
