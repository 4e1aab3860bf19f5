// Bit-parallel automata: many small automata, one in each bit of a few words. These are the arrays that program_view.h
// describes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lpe/automata/groups.h"
#include "lpe/program_view.h"

namespace raylex::lpe {

/// The automata of one program. Classes are not merged into columns yet.
struct BitParallelTables {
    std::array<std::uint32_t, ProgramView::parallel_widths> words{};  ///< of one bit, by width
    Group phase;                                                      ///< dead, start, underway, one state per terminal
    std::vector<std::vector<std::uint32_t>> masks;                    ///< [class]; all 0 where the path dies
    std::vector<std::uint32_t> accept;                                ///< [terminal][width][code][word]
    std::vector<ChannelList> lists;                                   ///< [terminal][automaton][8]
    static constexpr std::uint32_t first_ended = 3;                   ///< state of `phase` for terminal 0
};

[[nodiscard]] BitParallelTables pack_bit_parallel(const std::vector<Group>& automata,
                                                  const std::vector<ClassRole>& roles);

/// Words of a path's state that these automata take, without the phase.
[[nodiscard]] std::size_t parallel_word_count(const std::vector<Group>& automata, const std::vector<ClassRole>& roles);

}  // namespace raylex::lpe
