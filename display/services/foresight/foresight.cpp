#include "display/services/foresight/foresight.h"

#include <algorithm>

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
    if (program.has_lanes() || program.word_count == 0) return;
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
    for (const State first : setup.first_states_) join(at_camera_, states_[first]);
}

std::vector<std::uint64_t> Foresight::sets_of_terminals() const {
    std::vector<std::uint64_t> sets;
    for (const Ahead& ahead : states_)
        if (std::find(sets.begin(), sets.end(), ahead.terminals) == sets.end()) sets.push_back(ahead.terminals);
    return sets;
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
