// The arrays of a compiled program, in memory and in files (adopt/program_file.h). program_view.h explains them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lpe/language/class_table.h"
#include "lpe/program_view.h"

namespace raylex::lpe {

struct ProgramTables {
    std::vector<std::string> channel_names;
    std::uint32_t table_count = 0;
    std::uint32_t class_count = 1;
    std::vector<State> starts;
    std::vector<State> next_state{ProgramView::dead};
    std::vector<std::uint32_t> accept_begin{0, 0};
    std::vector<std::uint16_t> accept_lists;

    std::array<std::uint32_t, ProgramView::parallel_widths> parallel_words{};
    State first_ended = 0;
    std::vector<std::uint32_t> parallel_masks, parallel_accept, parallel_lists;

    ClassTable classes;                       ///< event -> fine class
    std::vector<EventClass> column_of_class;  ///< fine class -> column of the tables: the EventClass of the program

    /// Valid as long as the arrays do not move.
    [[nodiscard]] ProgramView view() const;
    /// The bytes of all arrays that following a path reads: everything except names and classes.
    [[nodiscard]] std::size_t bytes() const;
};

}  // namespace raylex::lpe
