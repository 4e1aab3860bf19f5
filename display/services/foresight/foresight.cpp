#include "display/services/foresight/foresight.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "display/services/foresight/state_steps.h"
#include "display/services/samples/branches.h"

namespace raylex::display {

using lpe::EventClass;
using lpe::State;

std::vector<EventClass> Foresight::distinct(std::vector<EventClass> classes) {
    std::sort(classes.begin(), classes.end());
    classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
    return classes;
}

/// Works on the program's table alone: state 0 is dead, and so are those that no word of the scene leads on from.
struct Foresight::Maker {
    const lpe::ProgramView& program;
    const std::vector<EventClass> scatterings, straight;
    std::vector<Ahead>& states;

    /// Calls visit(from, to) for every step by one of these events.
    template <class Visit>
    void for_each_step(std::span<const EventClass> events, Visit visit) const {
        for (State from = 1; from < program.state_count; ++from)
            for (const EventClass event : events)
                if (const State to = program.next(from, event); to != lpe::ProgramView::dead) visit(from, to);
    }

    /// Backwards from the states that accept with one event more.
    void find_anything() const {
        std::vector<std::uint8_t> anything(states.size());
        for (std::size_t state = 0; state < states.size(); ++state) anything[state] = states[state].anything;
        mark_backwards(anything, [&](auto visit) {
            for_each_step(scatterings, visit);
            for_each_step(straight, visit);
        });
        for (std::size_t state = 0; state < states.size(); ++state) states[state].anything = anything[state] != 0;
    }

    /// Which states paths of the scene come to, from `reached` on.
    void find_reached(std::vector<std::uint8_t>& reached) const {
        mark_backwards(reached, [&](auto visit) {
            const auto forwards = [&](State from, State to) { visit(to, from); };
            for_each_step(scatterings, forwards);
            for_each_step(straight, forwards);
        });
    }

    /// What can come behind cutouts can come before them.
    void pass_cutouts() const {
        for (bool changed = !straight.empty(); changed;) {
            changed = false;
            for_each_step(straight, [&](State from, State to) {
                const Ahead before = states[from];
                join(states[from], states[to]);
                changed |= before.terminals != states[from].terminals || before.scatters != states[from].scatters;
            });
        }
    }
};

Foresight::Foresight(const LpeSetup& setup, const Alphabet& alphabet) {
    const lpe::ProgramView& program = setup.program().view();
    if (program.word_count == 0) return;
    program_ = &program;
    terminals_ = distinct(alphabet.terminals);
    states_.assign(program.state_count, {0, false, false});
    const Maker make{program, distinct(alphabet.scatterings), distinct(alphabet.straight), states_};
    for (State state = 1; state < program.state_count; ++state) {
        Ahead& ahead = states_[state];
        for (const EventClass terminal : terminals_)
            if (!program.accepted(program.next(state, terminal)).empty()) ahead.terminals |= bit_of(terminal);
        ahead.anything = ahead.terminals != 0;
        for (const EventClass user : alphabet.user)
            ahead.anything |=
                !program.accepted(program.next(program.next(state, user), alphabet.user_terminal)).empty();
    }
    make.find_anything();
    make.for_each_step(make.scatterings, [&](State from, State to) { states_[from].scatters |= states_[to].anything; });
    make.pass_cutouts();
    at_camera_ = {0, false, false};
    if (setup.first_states_.empty()) return;
    const State* first = setup.first_states_.data();
    packed_ = program.has_lanes();
    const std::uint32_t tables = program.table_count - (packed_ ? 1 : 0);
    std::vector<std::uint8_t> reached(states_.size());
    for (std::uint32_t word = 0; word < tables; ++word) reached[first[word]] = 1;
    make.find_reached(reached);
    for (std::size_t state = 0; state < states_.size(); ++state)
        if (reached[state] != 0) add_set(sets_, states_[state].terminals);
    if (packed_) {
        underway_ = first[tables];
        foresee_lanes(alphabet, first + program.table_count);
    }
    at_camera_ = of_branch(first);
}

Foresight::Ahead Foresight::of_branch(const State* words) const {
    Ahead ahead{0, false, false};
    const std::uint32_t tables = program_->table_count - (packed_ ? 1 : 0);
    for (std::uint32_t i = 0; i < tables; ++i) join(ahead, states_[words[i]]);
    if (packed_ && words[tables] == underway_)
        for (const LanesAhead& lanes : lanes_)
            if (program_->any_lane_in(words + program_->table_count, lanes.masks.data())) join(ahead, lanes.ahead);
    return ahead;
}

Foresight::Ahead Foresight::of_packed(const Tracker& tracker) const {
    Ahead ahead{0, false, false};
    for (std::size_t branch = 0; branch < tracker.count_; ++branch)
        join(ahead, of_branch(&tracker.state_[branch * tracker.groups_]));
    return ahead;
}

Foresight::Ahead Foresight::after_packed(const Tracker& tracker, std::span<const EventClass> scatterings) const {
    Ahead ahead{0, false, false};
    std::array<State, Tracker::group_limit> moved;
    for (std::size_t branch = 0; branch < tracker.count_; ++branch)
        for (const EventClass event : scatterings)
            if (program_->advance(&tracker.state_[branch * tracker.groups_], event, moved.data()))
                join(ahead, of_branch(moved.data()));
    return ahead;
}

std::uint64_t Foresight::terminals_ever() const {
    if (states_.empty()) return ~std::uint64_t{0};
    return std::accumulate(sets_.begin(), sets_.end(), std::uint64_t{0}, std::bit_or<>());
}

std::uint64_t Foresight::state_of(const Tracker& tracker) const {
    if (states_.empty()) return 0;
    std::uint64_t state = 1;
    const std::size_t words = std::size_t{tracker.count_} * tracker.groups_;
    for (std::size_t i = 0; i < words; ++i) state = mix64(state ^ tracker.state_[i]);
    return state | 1;
}

std::uint64_t Foresight::bit_of(lpe::EventClass terminal) const {
    const auto at = std::lower_bound(terminals_.begin(), terminals_.end(), terminal) - terminals_.begin();
    return std::uint64_t{1} << std::min<std::ptrdiff_t>(at, 63);
}

}  // namespace raylex::display
