// Small automata side by side in the bits of a few words: the arrays that program_view.h describes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lpe/automata/groups.h"
#include "lpe/program_view.h"

namespace raylex::lpe {

/// Lanes of one program, classes not merged into columns yet.
struct LaneTables {
    std::array<std::uint32_t, ProgramView::lane_kinds> words{};  ///< of one plane, by kind
    std::uint32_t lane_count = 0;
    Group phase;                                     ///< dead, start, underway, one state per terminal
    std::vector<std::vector<std::uint32_t>> image;   ///< [class]; all 0 where the path dies
    std::vector<std::uint32_t> accept;               ///< [terminal][kind][code][word]
    std::vector<ChannelList> lists;                  ///< [terminal][lane][8]
    static constexpr std::uint32_t first_ended = 3;  ///< state of `phase` for terminal 0
};

[[nodiscard]] LaneTables pack_lanes(const std::vector<Group>& lanes, const std::vector<Place>& places);

/// Words that the lanes of these automata take, without the phase.
[[nodiscard]] std::size_t lane_word_count(const std::vector<Group>& lanes, const std::vector<Place>& places);

}  // namespace raylex::lpe
