// Which states of an automaton some way leads on from: what both directions of foresight ask.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "lpe/program.h"

namespace raylex::display {

/// Marks whatever leads to a marked state. for_each_step(visit) calls visit(from, to) for every step that counts.
template <class ForEachStep>
void mark_backwards(std::vector<std::uint8_t>& marked, ForEachStep for_each_step) {
    std::vector<std::vector<lpe::State>> before(marked.size());
    for_each_step([&](lpe::State from, lpe::State to) { before[to].push_back(from); });
    std::vector<lpe::State> open;
    for (lpe::State state = 0; state < marked.size(); ++state)
        if (marked[state] != 0) open.push_back(state);
    while (!open.empty()) {
        const lpe::State state = open.back();
        open.pop_back();
        for (const lpe::State from : before[state])
            if (std::exchange(marked[from], std::uint8_t{1}) == 0) open.push_back(from);
    }
}

}  // namespace raylex::display
