#include "display/services/liveness/liveness.h"

#include <functional>
#include <initializer_list>
#include <map>
#include <numeric>

#include "display/services/samples/branches.h"
#include "display/services/split_mix.h"
#include "lpe/automata/liveness_table.h"

namespace raylex::display {

using lpe::EventClass;
using lpe::ProgramView;
using lpe::State;
using lpe::StateSets;

std::vector<EventClass> Liveness::distinct(std::vector<EventClass> classes) {
    std::sort(classes.begin(), classes.end());
    classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
    return classes;
}

namespace {

/// One bit-parallel automaton alone. State code + 1 stands for a code of a path underway.
struct ParallelAutomaton {
    struct Place {
        State phase;
        std::uint32_t code;
    };
    const ProgramView& program;
    const ProgramView::Width& width;
    std::uint32_t word, bit;
    State underway;

    [[nodiscard]] bool in(const std::uint32_t* words) const { return (words[word] >> bit & 1U) != 0; }
    /// The code whose bits stand in these words, one for each bit.
    [[nodiscard]] std::uint32_t code(const std::uint32_t* words) const {
        std::uint32_t value = 0;
        for (std::uint32_t b = 0; b < width.bits; ++b) value |= std::uint32_t{in(words + b * width.words)} << b;
        return value;
    }
    [[nodiscard]] Place next(Place from, EventClass event) const {
        const std::uint32_t* masks = program.parallel_masks + std::size_t{event} * program.mask_stride;
        const std::uint32_t* tail = masks + program.mask_stride - ProgramView::mask_tail;
        if (from.phase != tail[1]) return {ProgramView::dead, 0};
        return {tail[2], code(masks + width.masks + std::size_t{from.code} * width.bits * width.words)};
    }
    [[nodiscard]] State step(State from, EventClass event) const {
        const Place to = next({underway, from - 1}, event);
        return to.phase == underway ? to.code + 1 : 0;
    }
    [[nodiscard]] bool accepts(State from, std::initializer_list<EventClass> end) const {
        Place at{underway, from - 1};
        for (const EventClass event : end) at = next(at, event);
        if (at.phase < program.first_ended) return false;
        return in(program.parallel_accept + std::size_t{at.phase - program.first_ended} * program.accept_stride +
                  width.accept + std::size_t{at.code} * width.words);
    }
};

}  // namespace

struct Liveness::Builder {
    Liveness& result;
    const Alphabet& alphabet;
    const std::vector<EventClass> scatterings = distinct(alphabet.scatterings), straight = distinct(alphabet.straight),
                                  user = distinct(alphabet.user), ends = distinct(alphabet.terminals);
    const std::vector<EventClass> steps = [this] {
        std::vector<EventClass> both = scatterings;
        both.insert(both.end(), straight.begin(), straight.end());
        return both;
    }();

    /// Adds to result.sets_ the terminals of states that are reached from `first`. `accepts(state, events)`: whether
    /// the automaton accepts after these events more.
    template <class Step, class Accepts>
    std::vector<LiveSet> run(std::size_t state_count, Step step, Accepts accepts, StateSets first) const {
        StateSets terminals(state_count), accepting(state_count);
        for (State state = 1; state < state_count; ++state) {
            for (const EventClass terminal : ends)
                if (accepts(state, {terminal})) terminals[state] |= result.bit_of(terminal);
            accepting[state] = terminals[state] != 0 || std::any_of(user.begin(), user.end(), [&](EventClass event) {
                                   return accepts(state, {event, alphabet.user_terminal});
                               });
        }
        const lpe::LivenessTable table(state_count, step);
        const StateSets anything = table.eventually(steps, std::move(accepting));
        const StateSets scatters = table.eventually(straight, table.before(scatterings, anything));
        terminals = table.eventually(straight, std::move(terminals));
        const StateSets reached = table.reached(steps, std::move(first));
        std::vector<LiveSet> live;
        for (State state = 0; state < state_count; ++state) {
            live.push_back({terminals[state], anything[state] != 0, scatters[state] != 0});
            const bool known =
                std::find(result.sets_.begin(), result.sets_.end(), terminals[state]) != result.sets_.end();
            if (reached[state] != 0 && !known) result.sets_.push_back(terminals[state]);
        }
        return live;
    }

    void find_tables(std::span<const State> first) const {
        const ProgramView& program = *result.program_;
        StateSets begin(program.state_count);
        for (const State state : first) begin[state] = 1;
        const auto step = [&](State from, EventClass event) { return program.next(from, event); };
        const auto accepts = [&](State state, std::initializer_list<EventClass> end) {
            for (const EventClass event : end) state = program.next(state, event);
            return !program.accepted(state).empty();
        };
        result.states_ = run(program.state_count, step, accepts, std::move(begin));
    }

    /// `first`: the bits of the codes after the camera event.
    void find_parallel(const State* first) const {
        const ProgramView& program = *result.program_;
        using Masks = std::vector<std::uint32_t>;
        const Masks none(program.accept_stride);
        Masks anything = none, scatters = none;
        std::array<Masks, 64> by_terminal;
        by_terminal.fill(none);
        for (const ProgramView::Width& width : program.widths)
            for (std::uint32_t i = 0; i < 32 * width.words; ++i) {
                const ParallelAutomaton one{program, width, i / 32, i % 32, result.underway_};
                StateSets begin(width.codes + 1);
                begin[one.code(first + width.state) + 1] = 1;
                const std::vector<LiveSet> live = run(
                    width.codes + 1, [&](State from, EventClass event) { return one.step(from, event); },
                    [&](State from, std::initializer_list<EventClass> end) { return one.accepts(from, end); }, begin);
                for (std::uint32_t code = 0; code < width.codes; ++code) {
                    const auto mark = [&](Masks& masks, bool is) {
                        masks[width.accept + std::size_t{code} * width.words + one.word] |= std::uint32_t{is}
                                                                                            << one.bit;
                    };
                    mark(anything, live[code + 1].anything);
                    mark(scatters, live[code + 1].scatters);
                    for (std::size_t t = 0; t < by_terminal.size(); ++t)
                        mark(by_terminal[t], (live[code + 1].terminals >> t & 1U) != 0);
                }
            }
        result.parallel_.push_back({{0, true, false}, std::move(anything)});
        result.parallel_.push_back({{0, false, true}, std::move(scatters)});
        std::map<Masks, std::uint64_t> terminals;  // terminals with equal masks are tested together
        for (std::size_t t = 0; t < by_terminal.size(); ++t) terminals[by_terminal[t]] |= std::uint64_t{1} << t;
        terminals.erase(none);
        for (const auto& [masks, bits] : terminals) result.parallel_.push_back({{bits, false, false}, masks});
    }
};

/// Gives terminals bits in the order of the scene. Terminals with which a class ends alike share one, so that its bits
/// do not depend on other channels.
void Liveness::find_bits(const LpeSetup& setup, const std::vector<EventClass>& terminals) {
    const ProgramView& program = *program_;
    std::vector<State> of_class;
    if (setup.is_of_class()) {
        const lpe::LivenessTable table(program.state_count,
                                       [&](State from, EventClass event) { return program.next(from, event); });
        StateSets reached(program.state_count);
        reached[program.starts[0]] = 1;
        reached = table.reached(lpe::all_classes(program.class_count), std::move(reached));
        for (State state = 1; state < program.state_count; ++state)
            if (reached[state] != 0) of_class.push_back(state);
    }
    std::map<std::vector<State>, std::size_t> number;
    bits_.resize(program.class_count);
    for (const EventClass terminal : terminals) {
        std::vector<State> alike;
        for (const State state : of_class) alike.push_back(program.accepted(program.next(state, terminal)).empty());
        if (!setup.is_of_class()) alike.push_back(terminal);
        const std::size_t bit = number.emplace(std::move(alike), number.size()).first->second;
        bits_[terminal] = std::uint64_t{1} << std::min<std::size_t>(bit, 63);
    }
}

Liveness::Liveness(const LpeSetup& setup, const Alphabet& alphabet) {
    const ProgramView& program = setup.main();
    if (program.word_count == 0) return;
    program_ = &program;
    find_bits(setup, alphabet.terminals);
    at_camera_ = {0, false, false};
    const Builder builder{*this, alphabet};
    const std::vector<State>& first = setup.first_states_;  // after the camera event; empty where all are dead
    has_parallel_ = program.has_parallel() && !first.empty();
    const std::size_t tables = first.empty() ? 0 : program.table_count - (has_parallel_ ? 1 : 0);
    builder.find_tables({first.data(), tables});
    std::sort(sets_.begin(), sets_.end());
    if (first.empty()) return;
    if (has_parallel_) {
        underway_ = first[tables];
        builder.find_parallel(first.data() + program.table_count);
    }
    at_camera_ = of_branch(first.data());
}

Liveness::LiveSet Liveness::of_branch(const State* words) const {
    LiveSet live{0, false, false};
    const std::uint32_t tables = program_->table_count - (has_parallel_ ? 1 : 0);
    for (std::uint32_t i = 0; i < tables; ++i) join(live, states_[words[i]]);
    if (has_parallel_ && words[tables] == underway_)
        for (const ParallelSet& set : parallel_)
            if (program_->any_parallel_in(words + program_->table_count, set.masks.data())) join(live, set.live);
    return live;
}

Liveness::LiveSet Liveness::of_parallel(const Tracker& tracker) const {
    LiveSet live{0, false, false};
    for (std::size_t branch = 0; branch < tracker.count_; ++branch)
        join(live, of_branch(&tracker.state_[branch * tracker.groups_]));
    return live;
}

Liveness::LiveSet Liveness::after_parallel(const Tracker& tracker, std::span<const EventClass> scatterings) const {
    LiveSet live{0, false, false};
    std::array<State, Tracker::group_limit> moved;
    for (std::size_t branch = 0; branch < tracker.count_; ++branch)
        for (const EventClass event : scatterings)
            if (program_->advance(&tracker.state_[branch * tracker.groups_], event, moved.data()))
                join(live, of_branch(moved.data()));
    return live;
}

std::uint64_t Liveness::live_terminals() const {
    if (states_.empty()) return ~std::uint64_t{0};
    return std::accumulate(sets_.begin(), sets_.end(), std::uint64_t{0}, std::bit_or<>());
}

std::uint64_t Liveness::state_of(const Tracker& tracker) const {
    if (states_.empty()) return 0;
    std::uint64_t state = 1;
    const std::size_t words = std::size_t{tracker.count_} * program_->word_count;
    for (std::size_t i = 0; i < words; ++i) state = mix_bits(state ^ tracker.state_[i]);
    return state | 1;
}

}  // namespace raylex::display
