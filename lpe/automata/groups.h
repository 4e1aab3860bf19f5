// Which channels share a table and which become bit-parallel automata (program_view.h): Baeza-Yates and Gonnet 1992,
// Navarro and Raffinot 2002.
//
// The rule: a path's state takes the fewest words. A table is one word, whatever the number of its states; automata of
// 1, 2 or 3 bits are 32 to a word for each bit, and one word more for the phase that they share.
//
// A table has that price only while its states grow like a sum. Automata are multiplied in a balanced tree, so that all
// but the last few products are small; a product of minimal automata that remembers which side accepts is minimal
// itself, so nothing is minimised on the way. Channels that look at the first few events have as many states together
// as apart, about. Each event that channels wait for anywhere on the path (C.*X.*) doubles the product: it adds one bit
// to the number of a state, and one bit is what such a channel takes as a bit-parallel automaton, where memory grows
// with the number of bits and not with its power of two. Hence four bounds, all counted in bits:
//
//     a product of tables     two bits more than both take side by side, and small tables (6 bits) always
//     two tables              are never worse than bit-parallel automata, which take two words at least
//     an automaton of 2 bits  joins a table where that takes clearly less than one bit there (half as many states more)
//     automata of 6 bits      in all are one small table: one word instead of two
//
// An event reads 1 word of a table, but 2, 8 or 24 masks for a word of automata of 1, 2 or 3 bits. So automata of 3
// bits stay in tables, unless that takes more words.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lpe/automata/dfa.h"
#include "lpe/program.h"

namespace raylex::lpe {

using ChannelList = std::vector<std::uint16_t>;

/// An automaton whose outputs are indices into `lists`; list 0 is empty.
struct Group {
    Dfa dfa;
    std::vector<ChannelList> lists{{}};
};

/// Where in a word of a renderer, C scatter* terminal, the events of a class can stand.
enum class ClassRole : std::uint8_t { nowhere, camera, scattering, terminal };
[[nodiscard]] std::vector<ClassRole> roles_of(const EventClasses& classes);

inline constexpr std::size_t code_limit = 8;

/// The states that a path underway can be in, the dead one first if it can; empty when they are more than the codes of
/// a bit-parallel automaton.
[[nodiscard]] std::vector<std::uint32_t> parallel_codes(const Dfa& dfa, const std::vector<ClassRole>& roles);

struct Grouping {
    std::vector<Group> tables;
    std::vector<Group> parallel;
    std::vector<ClassRole> parallel_roles;  ///< without events on which all of `parallel` die
};

/// Channel k accepts by dfas[k]. Where `places` is not empty, all are cut to words of a renderer; only then are there
/// bit-parallel automata. Throws Failure naming the channels when they fit in no way that the options allow.
[[nodiscard]] Grouping group_channels(std::vector<Dfa> dfas, std::span<const ChannelSource> channels,
                                      const std::vector<ClassRole>& roles, const CompileOptions& options);

/// Puts one more channel (a group of its own) where it hardly adds to what is there: into a table, beside the
/// bit-parallel automata if it takes one bit, or into a table of its own. False, and nothing done, if none of these.
[[nodiscard]] bool add_channel(Grouping& grouping, Group channel, const std::vector<ClassRole>& roles,
                               const CompileOptions& options);

}  // namespace raylex::lpe
