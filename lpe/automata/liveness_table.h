// Which states of an automaton lead where: one fixpoint for every question of liveness.
//
// An automaton here is a number of states and a function step(state, event class); state 0 is dead. Each state carries
// a set of up to 64 elements, as bits. The table moves such sets along the automaton's steps by the events E:
//
//     before(E, S)      X[q] = union of S[step(q, e)] over e in E: what one event leads to
//     eventually(E, S)  the least X with X = S | before(E, X): what zero or more events lead to
//     reached(E, S)     the least X that contains S and, with X[q], X[step(q, e)]: what zero or more events lead from
//
// Started from what states accept, eventually() finds the co-accessible states, the live ones; started from the first
// state, reached() finds the accessible ones. A reversed automaton (reversal.h) gives the same answers for paths that
// are known from their light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "lpe/program_view.h"

namespace raylex::lpe {

using StateSets = std::vector<std::uint64_t>;  ///< [state]

template <class Step>
class LivenessTable {
  public:
    LivenessTable(std::size_t state_count, Step step) : states_(static_cast<State>(state_count)), step_(step) {}

    [[nodiscard]] StateSets before(std::span<const EventClass> events, const StateSets& sets) const {
        StateSets result(states_);
        for_each_step(events, false, [&](State from, State to) { result[from] |= sets[to]; });
        return result;
    }
    [[nodiscard]] StateSets eventually(std::span<const EventClass> events, StateSets sets) const {
        return closed(events, std::move(sets), true);
    }
    [[nodiscard]] StateSets reached(std::span<const EventClass> events, StateSets sets) const {
        return closed(events, std::move(sets), false);
    }

  private:
    template <class Visit>
    void for_each_step(std::span<const EventClass> events, bool descending, Visit visit) const {
        for (State i = 1; i < states_; ++i) {
            const State from = descending ? states_ - i : i;
            for (const EventClass event : events) {
                if (const State to = step_(from, event); to != 0) { visit(from, to); }
            }
        }
    }
    /// Sweeps until nothing grows. Successors mostly have higher numbers, so sets that move backwards start at the end.
    [[nodiscard]] StateSets closed(std::span<const EventClass> events, StateSets sets, bool backwards) const {
        for (bool grew = !events.empty(); grew;) {
            grew = false;
            for_each_step(events, backwards, [&](State from, State to) {
                std::uint64_t& grows = sets[backwards ? from : to];
                const std::uint64_t joined = sets[from] | sets[to];
                grew = grew || joined != grows;
                grows = joined;
            });
        }
        return sets;
    }

    State states_;
    Step step_;
};

/// Every event class of a program.
[[nodiscard]] inline std::vector<EventClass> all_classes(std::size_t class_count) {
    std::vector<EventClass> classes(class_count);
    std::iota(classes.begin(), classes.end(), EventClass{0});
    return classes;
}

}  // namespace raylex::lpe
