// Complete deterministic automata with outputs (Moore machines) over event classes. State 0 is dead: it has output 0,
// and every event leads back to it. Output 0 means "nothing"; the caller defines other outputs (1 for acceptance, a
// count, an index of a list of channels).
//
// Classes that an automaton treats alike share a column, so tables stay small when other channels need more classes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "lpe/language/event_classes.h"

namespace raylex::lpe {

struct Dfa {
    std::vector<std::uint16_t> column_of_class;
    std::size_t columns = 0;
    std::vector<std::uint32_t> next;    // [state][column]
    std::vector<std::uint32_t> output;  // [state]
    std::uint32_t start = 0;

    [[nodiscard]] std::size_t states() const { return output.size(); }
    [[nodiscard]] std::uint32_t step(std::uint32_t state, EventClass event_class) const {
        return next[state * columns + column_of_class[event_class]];
    }
    /// One line per state: "3 [1]: 0 4 4". For tests and debugging.
    [[nodiscard]] std::string dump() const;
};

/// The automaton of the empty language.
[[nodiscard]] Dfa empty_dfa(std::size_t class_count);

/// The smallest automaton with the same outputs (Hopcroft). States are numbered in breadth-first order from the start,
/// so equal languages give equal tables.
[[nodiscard]] Dfa minimized(const Dfa& dfa);

/// How a product combines two outputs. `combine` must return 0 for (0, 0).
struct Combination {
    std::uint32_t (*combine)(void* context, std::uint32_t a, std::uint32_t b) = nullptr;
    void* context = nullptr;
    bool needs_both = false;   ///< the pair is dead as soon as one side is dead (intersection)
    bool needs_first = false;  ///< the pair is dead as soon as the first side is dead (difference)
};

[[nodiscard]] Combination union_of();
[[nodiscard]] Combination intersection_of();
[[nodiscard]] Combination difference_of();
/// Counts accepting sides: 0, 1, or 2 for "2 or more".
[[nodiscard]] Combination count_of();

/// The product automaton of all reachable pairs; nothing if it needs more than `state_cap` states or too large a table.
/// The product of minimal automata is minimal if the output determines both operands' outputs.
[[nodiscard]] std::optional<Dfa> product(const Dfa& a, const Dfa& b, const Combination& combination,
                                         std::size_t state_cap);

/// The shortest word of classes whose output satisfies `wanted`; ties go to the lowest classes.
[[nodiscard]] std::optional<std::vector<EventClass>> shortest_path_string(const Dfa& dfa,
                                                                          bool (*wanted)(std::uint32_t output));

}  // namespace raylex::lpe
