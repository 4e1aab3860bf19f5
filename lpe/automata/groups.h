// Which channels share a table and which are packed into lanes (program_view.h).
//
// Automata are multiplied together, in a balanced tree so that all but the last few products are small. A product of
// minimal automata that remembers which side accepts is minimal itself, so nothing is minimised on the way. That is
// right for channels that look at the first few events: their products grow like sums. Where channels ask about
// anything "anywhere" on the path (C.*X.*) the product doubles with each of them; a product that grows out of
// proportion to its parts is given up, and such channels become lanes, which cost bits.
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
enum class Place : std::uint8_t { nowhere, camera, scattering, terminal };
[[nodiscard]] std::vector<Place> places_of(const EventClasses& classes);

inline constexpr std::size_t lane_code_limit = 8;

/// The states that a path underway can be in, the dead one first if it can; empty when they are more than a lane has
/// codes for.
[[nodiscard]] std::vector<std::uint32_t> lane_codes(const Dfa& dfa, const std::vector<Place>& places);

struct Grouping {
    std::vector<Group> tables;
    std::vector<Group> lanes;
    std::vector<Place> lane_places;  ///< as the lanes see it: events on which all of them die can stand nowhere
};

/// Channel k accepts by dfas[k]; all are cut to words of a renderer when `places` is not empty, and only then are lanes
/// made. Throws Failure naming the channels when they fit in no way that the options allow.
[[nodiscard]] Grouping group_channels(std::vector<Dfa> dfas, std::span<const ChannelSource> channels,
                                      const std::vector<Place>& places, const CompileOptions& options);

/// Puts one more channel (a group of its own) where it hardly adds to what is there: into a table, a lane, a table of
/// its own. False, and nothing done, when that is nowhere.
[[nodiscard]] bool add_channel(Grouping& grouping, Group channel, const std::vector<Place>& places,
                               const CompileOptions& options);

}  // namespace raylex::lpe
