// Limits that keep the processing of any input, however hostile, within seconds and 256 MiB. Each is far above what
// people write. Input above a limit is an error that names the limit, never a crash.
#pragma once

#include <cstddef>

namespace raylex::lpe::limits {

inline constexpr std::size_t text_bytes = 65'536;          ///< one expression
inline constexpr int nesting = 200;                        ///< nesting depth of brackets, parentheses and '!'
inline constexpr int operators = 400;                      ///< '&' and '-' in one expression: each adds a level to the
                                                           ///< tree
inline constexpr int repetitions = 1'000;                  ///< n and m of {n,m}
inline constexpr std::size_t nfa_states = 50'000;          ///< one expression after unrolling its repetitions
inline constexpr std::size_t subset_elements = 4'000'000;  ///< NFA states in all subsets of one determinisation
inline constexpr std::size_t table_entries = 8'000'000;    ///< states times columns of one automaton
inline constexpr std::size_t work_steps = 100'000'000;     ///< elementary steps for one expression, about two seconds
inline constexpr std::size_t event_classes = 4'096;        ///< kinds of events that a set of channels distinguishes
inline constexpr std::size_t event_points = 50'000;     ///< combinations of core and labels that are tested to describe
                                                        ///< events in words
inline constexpr std::size_t graph_states = 250;        ///< states of a drawn automaton
inline constexpr std::size_t label_tests = 20'000'000;  ///< label comparisons during the search for event classes
inline constexpr int path_string_depth = 128;           ///< largest limit on scattering events in W; above it W is not
                                                        ///< limited
inline constexpr std::size_t macro_depth = 64;          ///< nesting depth of macros
inline constexpr std::size_t channel_file_bytes = 16'777'216;  ///< a file of channels (RIB, USD ASCII, ini, TOML)
inline constexpr std::size_t file_channels = 16'384;           ///< channels, macros and options of one file
inline constexpr std::size_t file_nesting = 500;               ///< nesting depth of brackets and prims in such a file
inline constexpr std::size_t channels = 65'000;                ///< channels that are compiled together
inline constexpr std::size_t group_variants = 1'024;           ///< symbol sequences of one osl <...>
inline constexpr std::size_t glob_states = 20'000;             ///< states of the joint automaton of the globs of one
                                                               ///< slot
inline constexpr std::size_t boolean_states = 50'000;          ///< states of automata below &, - and !, and of those in
                                                               ///< proofs

}  // namespace raylex::lpe::limits
