#include "lpe/reversal.h"

#include <algorithm>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "lpe/automata/liveness_table.h"
#include "lpe/failure.h"

namespace raylex::lpe {

namespace {

struct VectorHash {
    std::size_t operator()(const std::vector<std::uint32_t>& values) const {
        std::uint64_t hash = 0xCBF29CE484222325ULL;
        for (const std::uint32_t value : values) {
            hash = (hash ^ value) * 0x100000001B3ULL;
            hash ^= hash >> 29;
        }
        return static_cast<std::size_t>(hash);
    }
};

}  // namespace

/// Determinises the reversal of each table: a reversed state maps each forward state to its outcome after the end read
/// so far.
struct ReversedProgram::Builder {
    const ProgramView& view;
    const ReverseOptions& options;
    ReversedProgram& result;
    std::size_t bytes = 0;

    /// The rows of one table, all that its start reaches, stand together.
    Table rows_of(State start) const {
        const LivenessTable steps(view.state_count,
                                  [this](State from, EventClass event) { return view.next(from, event); });
        StateSets reached(view.state_count);
        reached[start] = 1;
        reached = steps.reached(all_classes(view.class_count), std::move(reached));
        Table table;
        table.rows = 1;
        for (State state = 1; state < view.state_count; ++state) {
            if (reached[state] == 0) { continue; }
            if (table.first_row == 0) { table.first_row = state; }
            table.rows = state - table.first_row + 2;
        }
        return table;
    }

    /// `of_phase`: the outcome of a state is that state, not a representative that accepts the same channels.
    Table reverse(State start, bool of_phase) {
        Table table = rows_of(start);
        const auto row_state = [&table](std::uint32_t row) { return row == 0 ? 0 : table.first_row + row - 1; };
        std::vector<State> values(table.rows, 0);
        std::map<std::vector<std::uint16_t>, State> first_that_accepts{{{}, 0}};
        for (std::uint32_t row = 1; row < table.rows; ++row) {
            const State state = row_state(row);
            const std::span<const std::uint16_t> channels = view.accepted(state);
            values[row] = of_phase
                              ? state
                              : first_that_accepts.try_emplace({channels.begin(), channels.end()}, state).first->second;
        }
        std::unordered_map<std::vector<std::uint32_t>, State, VectorHash> number;
        std::vector<const std::vector<std::uint32_t>*> order;
        const auto state_of = [&](std::vector<std::uint32_t> ends) {
            const auto [place, fresh] = number.emplace(std::move(ends), static_cast<State>(order.size()));
            if (fresh) {
                bytes += 4 * (std::size_t{table.rows} + view.class_count);
                if (order.size() >= options.state_cap || bytes > options.byte_cap) {
                    fail("reversing this program needs more than " + std::to_string(order.size()) + " states or " +
                             std::to_string(options.byte_cap >> 20) + " MiB",
                         "request fewer channels, or channels that count fewer events after a `.*`");
                }
                order.push_back(&place->first);
            }
            return place->second;
        };
        state_of(std::vector<std::uint32_t>(table.rows, 0));
        result.starts_.push_back(state_of(std::move(values)));
        for (std::size_t state = 0; state < order.size(); ++state) {
            for (std::uint32_t event = 0; event < view.class_count; ++event) {
                std::vector<std::uint32_t> before(table.rows, 0);
                for (std::uint32_t row = 1; row < table.rows; ++row) {
                    const State to = view.next(row_state(row), static_cast<EventClass>(event));
                    before[row] = to == 0 ? 0 : (*order[state])[to - table.first_row + 1];
                }
                table.next.push_back(state_of(std::move(before)));
            }
        }
        for (const std::vector<std::uint32_t>* ends : order) {
            table.outcome.insert(table.outcome.end(), ends->begin(), ends->end());
        }
        return table;
    }

    void find_zero_codes() {
        for (std::uint32_t terminal = 0; view.first_ended + terminal < view.state_count; ++terminal) {
            const std::uint32_t* accept = view.parallel_accept + std::size_t{terminal} * view.accept_stride;
            const auto zero_accepts = [accept](const ProgramView::Width& width) {
                const std::uint32_t* masks = accept + width.accept;
                return std::any_of(masks, masks + width.words, [](std::uint32_t automata) { return automata != 0; });
            };
            result.zero_accepts_.push_back(std::any_of(view.widths.begin(), view.widths.end(), zero_accepts));
        }
    }

    void run() {
        const std::size_t tables = view.table_count - (view.has_parallel() ? 1 : 0);
        for (std::size_t g = 0; g < tables; ++g) { result.tables_.push_back(reverse(view.starts[g], false)); }
        if (!view.has_parallel()) { return; }
        result.phase_ = reverse(view.starts[tables], true);
        find_zero_codes();
        // The empty end maps every code to itself: bit b of code c in the word of code c and bit b.
        for (const ProgramView::Width& width : view.widths) {
            for (std::uint32_t code = 0; code < width.codes; ++code) {
                for (std::uint32_t bit = 0; bit < width.bits; ++bit) {
                    result.starts_.insert(result.starts_.end(), width.words, (code >> bit & 1U) != 0 ? ~0U : 0U);
                }
            }
        }
    }
};

Result<ReversedProgram> ReversedProgram::build(const ProgramView& program, const ReverseOptions& options) {
    return guarded([&] {
        ReversedProgram reversed;
        reversed.program_ = program;
        Builder{program, options, reversed}.run();
        return reversed;
    });
}

bool ReversedProgram::prepend(const State* from, EventClass event, State* to) const noexcept {
    const ProgramView& program = program_;
    State alive = 0;
    const std::size_t words = tables_.size() + (program.has_parallel() ? 1 : 0);
    for (std::size_t g = 0; g < words; ++g) {
        to[g] = table(g).next[std::size_t{from[g]} * program.class_count + event];
        alive |= to[g];
    }
    if (program.has_parallel()) {
        program.compose_parallel(from + words, program.parallel_masks + std::size_t{event} * program.mask_stride,
                                 to + words);
    }
    return alive != 0;
}

bool ReversedProgram::connect(const State* camera, const State* light, State* whole) const noexcept {
    const std::size_t phase = tables_.size();
    State alive = 0;
    for (std::size_t g = 0; g < phase; ++g) {
        whole[g] = outcome(g, camera[g], light[g]);
        alive |= whole[g];
    }
    if (!program_.has_parallel()) { return alive != 0; }
    whole[phase] = outcome(phase, camera[phase], light[phase]);
    const std::uint32_t mask = whole[phase] >= program_.first_ended ? ~0U : 0U;
    const std::uint32_t any = program_.move_parallel(camera + phase + 1, light + phase + 1, mask, whole + phase + 1);
    return alive != 0 || any != 0 || (mask != 0 && zero_accepts_[whole[phase] - program_.first_ended] != 0);
}

std::size_t ReversedProgram::bytes() const noexcept {
    std::size_t words = phase_.next.size() + phase_.outcome.size();
    for (const Table& table : tables_) { words += table.next.size() + table.outcome.size(); }
    return sizeof(State) * words;
}

}  // namespace raylex::lpe
