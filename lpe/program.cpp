// Channels to tables: every channel becomes a minimal automaton (automata/languages.h), these become groups and
// bit-parallel automata (automata/groups.h, automata/bit_parallel.h), and those are laid out as arrays here.
#include "lpe/program.h"

#include <algorithm>
#include <map>
#include <utility>

#include "lpe/automata/bit_parallel.h"
#include "lpe/automata/groups.h"
#include "lpe/automata/languages.h"
#include "lpe/automata/layout.h"
#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// Writes tables and bit-parallel automata as one set of arrays.
class Layout {
  public:
    Layout(const EventClasses& classes, const Grouping& grouping) {
        if (!grouping.parallel.empty()) { parallel_ = pack_bit_parallel(grouping.parallel, grouping.parallel_roles); }
        merge_columns(classes, grouping);
        tables_.classes = classes.table();
        tables_.next_state.assign(tables_.class_count, Program::dead);
        for (const Group& group : grouping.tables) { append(group); }
        if (!grouping.parallel.empty()) { append_parallel(); }
        tables_.table_count = static_cast<std::uint32_t>(grouping.tables.size() + (grouping.parallel.empty() ? 0 : 1));
    }

    ProgramTables take() { return std::move(tables_); }

  private:
    /// Classes that every group treats alike share a column.
    void merge_columns(const EventClasses& classes, const Grouping& grouping) {
        std::map<std::vector<std::uint32_t>, EventClass> columns;
        std::map<std::vector<std::uint32_t>, std::uint32_t> masks;
        for (std::size_t k = 0; k < classes.count(); ++k) {
            std::vector<std::uint32_t> key;
            for (const Group& group : grouping.tables) { key.push_back(group.dfa.column_of_class[k]); }
            if (!grouping.parallel.empty()) {
                key.push_back(parallel_.phase.dfa.column_of_class[k]);
                key.push_back(
                    masks.emplace(parallel_.masks[k], static_cast<std::uint32_t>(masks.size())).first->second);
            }
            const auto [place, fresh] = columns.emplace(std::move(key), static_cast<EventClass>(columns.size()));
            if (fresh) { class_of_column_.push_back(k); }
            tables_.column_of_class.push_back(place->second);
        }
        tables_.class_count = static_cast<std::uint32_t>(class_of_column_.size());
    }

    void append(const Group& group) {
        const auto base = static_cast<State>(tables_.accept_begin.size() - 2);  // state 0 is shared
        const auto global = [base](std::uint32_t state) { return state == 0 ? Program::dead : base + state; };
        tables_.starts.push_back(global(group.dfa.start));
        for (std::uint32_t state = 1; state < group.dfa.states(); ++state) {
            for (const std::size_t event_class : class_of_column_) {
                tables_.next_state.push_back(global(group.dfa.step(state, static_cast<EventClass>(event_class))));
            }
            append_list(group.lists[group.dfa.output[state]]);
            tables_.accept_begin.push_back(static_cast<std::uint32_t>(tables_.accept_lists.size()));
        }
    }

    void append_parallel() {
        const auto base = static_cast<State>(tables_.accept_begin.size() - 2);
        tables_.first_ended = base + BitParallelTables::first_ended;
        append(parallel_.phase);
        tables_.parallel_words = parallel_.words;
        for (const std::size_t event_class : class_of_column_) {
            const std::vector<std::uint32_t>& masks = parallel_.masks[event_class];
            tables_.parallel_masks.insert(tables_.parallel_masks.end(), masks.begin(), masks.end());
            State needed = ~State{0}, reached = Program::dead;  // no phase leads on
            for (State phase = 1; phase < BitParallelTables::first_ended; ++phase) {
                const State to = parallel_.phase.dfa.step(phase, static_cast<EventClass>(event_class));
                if (to != 0) {
                    needed = base + phase;
                    reached = base + to;
                }
            }
            tables_.parallel_masks.push_back(needed);
            tables_.parallel_masks.push_back(reached);
        }
        tables_.parallel_accept = parallel_.accept;
        for (const ChannelList& list : parallel_.lists) {
            tables_.parallel_lists.push_back(static_cast<std::uint32_t>(tables_.accept_lists.size()));
            append_list(list);
        }
        tables_.parallel_lists.push_back(static_cast<std::uint32_t>(tables_.accept_lists.size()));
        tables_.starts.resize(tables_.starts.size() + ProgramView::widths_of(parallel_.words).back().state, 0);
    }

    void append_list(const ChannelList& list) {
        tables_.accept_lists.insert(tables_.accept_lists.end(), list.begin(), list.end());
    }

    ProgramTables tables_;
    BitParallelTables parallel_;
    std::vector<std::size_t> class_of_column_;
};

}  // namespace

ProgramTables lay_out(const EventClasses& classes, std::vector<Dfa> dfas, std::span<const ChannelSource> channels,
                      const CompileOptions& options) {
    const std::vector<ClassRole> roles = options.any_path_string ? std::vector<ClassRole>{} : roles_of(classes);
    return lay_out(classes, group_channels(std::move(dfas), channels, roles, options), channels, options);
}

ProgramTables lay_out(const EventClasses& classes, const Grouping& grouping, std::span<const ChannelSource> channels,
                      const CompileOptions& options) {
    const std::size_t parallel_words =
        grouping.parallel.empty() ? 0 : 1 + parallel_word_count(grouping.parallel, grouping.parallel_roles);
    if (grouping.tables.size() + parallel_words > options.word_cap) {
        fail("these channels need " + std::to_string(grouping.tables.size() + parallel_words) + " words of state; " +
                 std::to_string(options.word_cap) + " are allowed",
             "expressions such as C.*X.* take one bit each and more; use fewer of them at a time");
    }
    ProgramTables tables = Layout(classes, grouping).take();
    for (const ChannelSource& channel : channels) { tables.channel_names.push_back(channel.name); }
    return tables;
}

ProgramView ProgramTables::view() const {
    ProgramView view;
    view.word_count = static_cast<std::uint32_t>(starts.size());
    view.table_count = table_count;
    view.class_count = class_count;
    view.state_count = static_cast<std::uint32_t>(accept_begin.size() - 1);
    view.channel_count = static_cast<std::uint32_t>(channel_names.size());
    view.starts = starts.data();
    view.next_state = next_state.data();
    view.accept_begin = accept_begin.data();
    view.accept_lists = accept_lists.data();
    view.widths = ProgramView::widths_of(parallel_words);
    view.mask_stride = view.widths.back().masks + ProgramView::mask_tail;
    view.accept_stride = view.widths.back().accept;
    view.first_ended = first_ended;
    view.parallel_masks = parallel_masks.data();
    view.parallel_accept = parallel_accept.data();
    view.parallel_lists = parallel_lists.data();
    return view;
}

std::size_t ProgramTables::bytes() const {
    return sizeof(State) * (starts.size() + next_state.size()) + sizeof(std::uint16_t) * accept_lists.size() +
           sizeof(std::uint32_t) *
               (accept_begin.size() + parallel_masks.size() + parallel_accept.size() + parallel_lists.size());
}

Program::Program() : view_(tables_.view()) {}

Result<Program> Program::compile(std::span<const ChannelSource> channels, const CompileOptions& options) {
    return guarded([&]() -> Program {
        if (channels.size() > limits::channels) {
            fail(std::to_string(channels.size()) + " channels; at most " + std::to_string(limits::channels) +
                 " can be compiled together");
        }
        LanguageOptions language_options;
        language_options.state_cap = std::max(options.state_cap, limits::boolean_states);
        language_options.renderer_path_strings = !options.any_path_string;
        Languages languages = build_languages(channels, language_options);
        return Program(lay_out(*languages.classes, std::move(languages.channels), channels, options));
    });
}

Program Program::with_columns(std::span<const EventClass> columns) const {
    ProgramTables tables = tables_;
    tables.class_count = static_cast<std::uint32_t>(columns.size());
    tables.next_state.clear();
    tables.next_state.reserve(std::size_t{view_.state_count} * columns.size());
    for (State state = 0; state < view_.state_count; ++state) {
        for (const EventClass column : columns) { tables.next_state.push_back(view_.next(state, column)); }
    }
    tables.parallel_masks.clear();
    for (const EventClass column : columns) {
        if (!view_.has_parallel()) { break; }
        const std::uint32_t* masks = view_.parallel_masks + std::size_t{column} * view_.mask_stride;
        tables.parallel_masks.insert(tables.parallel_masks.end(), masks, masks + view_.mask_stride);
    }
    tables.column_of_class.assign(tables.column_of_class.size(), EventClass{0});
    return Program(std::move(tables));
}

EventClass Program::classify(const Event& event) const {
    return tables_.column_of_class.empty() ? EventClass{0} : tables_.column_of_class[tables_.classes.classify(event)];
}

bool Program::follows(EventClass event) const {
    const bool has_parallel = view_.has_parallel();
    const State rows = has_parallel ? view_.first_ended - 2 : view_.state_count;  // without those of the phase
    for (State state = 0; state < rows; ++state) {
        if (view_.next(state, event) != dead) { return true; }
    }
    if (!has_parallel) { return false; }
    const State last_interior = view_.first_ended - 1;
    const std::uint32_t* masks = view_.parallel_masks + std::size_t{event} * view_.mask_stride;
    return (view_.next(last_interior - 1, event) != dead || view_.next(last_interior, event) != dead) &&
           std::any_of(masks, masks + view_.mask_stride - 2, [](std::uint32_t word) { return word != 0; });
}

void Program::advance(std::span<State> states, std::span<const EventClass> events) const noexcept {
    if (view_.word_count == 1) {
        for (std::size_t path = 0; path < events.size(); ++path) {
            states[path] = view_.next(states[path], events[path]);
        }
        return;
    }
    for (std::size_t path = 0; path < events.size(); ++path) {
        State* words = states.data() + path * view_.word_count;
        view_.advance(words, events[path], words);
    }
}

void Program::accepts(std::span<const State> states, std::span<std::uint32_t> masks) const noexcept {
    std::fill(masks.begin(), masks.end(), 0U);
    const std::size_t stride = mask_words();
    const std::size_t paths = view_.word_count == 0 ? 0 : states.size() / view_.word_count;
    for (std::size_t path = 0; path < paths; ++path) {
        std::uint32_t* mask = masks.data() + path * stride;
        view_.for_each_accepted(states.data() + path * view_.word_count,
                                [mask](std::uint16_t channel) { mask[channel / 32] |= 1U << channel % 32; });
    }
}

}  // namespace raylex::lpe
