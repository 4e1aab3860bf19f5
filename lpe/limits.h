// Bounds that keep any input, however hostile, within seconds and 256 MiB. Each is far above what people write; passing
// one is an error that says so, never a crash.
#pragma once

#include <cstddef>

namespace raylex::lpe::limits {

inline constexpr std::size_t text_bytes = 65'536;          ///< one expression
inline constexpr int nesting = 200;                        ///< brackets, parentheses and '!' inside one another
inline constexpr int operators = 400;                      ///< '&' and '-' in one expression: each nests the tree once
inline constexpr int repetitions = 1'000;                  ///< n and m of {n,m}
inline constexpr std::size_t nfa_states = 50'000;          ///< one expression after unrolling its repetitions
inline constexpr std::size_t subset_elements = 4'000'000;  ///< NFA states held by all subsets of one determinisation
inline constexpr std::size_t table_entries = 8'000'000;    ///< states times columns of one automaton
inline constexpr std::size_t work_steps = 100'000'000;  ///< elementary steps spent on one expression, about two seconds
inline constexpr std::size_t event_classes = 4'096;     ///< kinds of events that a set of channels tells apart
inline constexpr std::size_t event_points =
    50'000;                                       ///< combinations of core and labels looked at to tell events in words
inline constexpr std::size_t graph_states = 250;  ///< of an automaton that is drawn
inline constexpr std::size_t label_tests = 20'000'000;  ///< label comparisons while event classes are found
inline constexpr int word_depth = 128;                  ///< scattering events to which W is cut; longer limits are none
inline constexpr std::size_t macro_depth = 64;          ///< macros that use one another
inline constexpr std::size_t channel_file_bytes = 16'777'216;  ///< a file of channels (RIB, USD ASCII, ini, TOML)
inline constexpr std::size_t file_channels = 16'384;           ///< channels, macros and options of one file
inline constexpr std::size_t file_nesting = 500;               ///< brackets and prims inside one another in such a file
inline constexpr std::size_t channels = 65'000;                ///< compiled together
inline constexpr std::size_t group_variants = 1'024;           ///< slot sequences that one osl <...> stands for
inline constexpr std::size_t glob_states = 20'000;             ///< joint automaton of the label globs of one slot
inline constexpr std::size_t boolean_states = 50'000;          ///< automata below &, - and !, and those of proofs

}  // namespace raylex::lpe::limits
