// A compiled set of channels: tables that match path events for all channels at once.
//
// A Program is one minimised deterministic automaton per group of channels; nearly always there is one group. Channels
// that would multiply with one another (`C.*X.*` with many labels X) are bit-parallel automata instead. The state
// of a path is a short list of words, nearly always one; program_view.h says what they are. Nothing here allocates, and
// a Program may be used by any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lpe/automata/program_tables.h"
#include "lpe/event.h"
#include "lpe/program_view.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct SourceMap;  // lpe/language/source_map.h
class Vocabulary;  // lpe/adopt/vocabulary.h

/// A channel as input of the compiler. `expression` can have prefixes ("unoccluded;...") and the mark "lpe:".
struct ChannelSource {
    std::string name{};
    std::string expression{};
    Dialect dialect = Dialect::renderman;
    std::string origin{};  ///< for errors: the file or option that contains the text
    int origin_line = 0;   ///< line in `origin` of the first character of the expression; 0: unknown
    int origin_column = 0;
    /// If not empty, the channel has no expression: it accepts every path string of W (lpe/path_strings.h) that none of
    /// these channels accepts (indices into the list that is compiled).
    std::vector<std::size_t> rest_of{};
    /// The origin of each byte of the expression if it is not one place in one line (escapes, macros). Errors then use
    /// it, and `origin` is only a name for the whole.
    std::shared_ptr<const SourceMap> map{};
    /// The renderer's own names of events and lobes, for use in the expression.
    std::shared_ptr<const Vocabulary> vocabulary{};
};

struct CompileOptions {
    std::size_t state_cap = 50'000;  ///< states of one group before channels are distributed over more groups; a single
                                     ///< channel can have more, up to a fixed limit
    std::size_t group_cap = 8;       ///< groups; more are an error that names the channels
    std::size_t word_cap = 32;       ///< words of a path's state: groups, plus the words of packed channels
    /// Renderers report path strings of the form C (R | T | V | user)* (L | B | O), and by default a Program
    /// distinguishes only these. Its tables then are several times smaller, and a state is dead as soon as no such path
    /// string can be completed. With `any_path_string` the program follows any sequence of events, as conformance
    /// vectors need.
    bool any_path_string = false;
    /// Program::compile() gives the first channel a table of its own, word 0 of the state, whatever the others are.
    bool first_alone = false;
};

class Program {
  public:
    static constexpr State dead = ProgramView::dead;  ///< the only table state from which nothing can be accepted

    /// A program without channels.
    Program();
    /// Takes tables that are valid (adopt/program_file.h checks those of a file).
    explicit Program(ProgramTables tables) : tables_(std::move(tables)), view_(tables_.view()) {}
    Program(Program&&) noexcept = default;
    Program& operator=(Program&&) noexcept = default;
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    static Result<Program> compile(std::span<const ChannelSource> channels, const CompileOptions& options = {});

    /// A program with other columns: column k behaves like column `columns[k]` of this one. It serves callers that
    /// distinguish more events than the channels do, and that classify events themselves: classify() of the result does
    /// not use the new columns.
    [[nodiscard]] Program with_columns(std::span<const EventClass> columns) const;

    /// The column of the transition table for `event`. Call it once per kind of event, not in the inner loop. New
    /// labels need no new program: labels that no expression names share a class.
    [[nodiscard]] EventClass classify(const Event& event) const;

    /// Returns whether an event of this class can be part of an accepted path. Not for the inner loop.
    [[nodiscard]] bool follows(EventClass event) const;

    /// The number of words in a path's state.
    [[nodiscard]] std::size_t word_count() const noexcept { return view_.word_count; }
    /// The state before the camera event.
    [[nodiscard]] std::span<const State> starts() const noexcept { return tables_.starts; }
    /// Moves one path along one event. Both states have word_count() words; `to` can be `from`. Returns false when no
    /// channel can accept the path now or after further events.
    bool advance(const State* from, EventClass event, State* to) const noexcept {
        return view_.advance(from, event, to);
    }
    /// Calls visit(channel) for every channel (index into the compiled list) whose expression accepts the path string
    /// so far.
    template <class Visit>
    void for_each_accepted(const State* states, Visit&& visit) const {
        view_.for_each_accepted(states, visit);
    }
    [[nodiscard]] bool accepts_any_of(const State* states) const noexcept { return view_.accepts_any(states); }

    /// Moves many paths, states[path][word], each along its own event and in place.
    void advance(std::span<State> states, std::span<const EventClass> events) const noexcept;
    /// Evaluates many paths: sets bit `channel` of masks[path][mask_words()] where that channel accepts, and clears all
    /// other bits.
    void accepts(std::span<const State> states, std::span<std::uint32_t> masks) const noexcept;
    [[nodiscard]] std::size_t mask_words() const noexcept { return (view_.channel_count + 31) / 32; }

    // For states whose machine words are all rows of tables: the case if !view().has_parallel(), and always with
    // CompileOptions::any_path_string or with a single channel.
    [[nodiscard]] State next(State state, EventClass event) const noexcept { return view_.next(state, event); }
    /// The channels that accept in the state, ascending.
    [[nodiscard]] std::span<const std::uint16_t> accepted(State state) const noexcept { return view_.accepted(state); }
    [[nodiscard]] bool accepts_any(State state) const noexcept { return !accepted(state).empty(); }

    [[nodiscard]] std::size_t state_count() const noexcept { return view_.state_count; }
    [[nodiscard]] std::size_t class_count() const noexcept { return view_.class_count; }
    /// Equal to word_count(): one word per group of channels, plus the words of packed channels.
    [[nodiscard]] std::size_t group_count() const noexcept { return view_.word_count; }
    [[nodiscard]] std::size_t channel_count() const noexcept { return view_.channel_count; }

    /// The program as plain data; valid as long as the program exists.
    [[nodiscard]] const ProgramView& view() const noexcept { return view_; }
    [[nodiscard]] const ProgramTables& tables() const noexcept { return tables_; }

  private:
    ProgramTables tables_;
    ProgramView view_;  // points into tables_; moving a program does not move the arrays
};

}  // namespace raylex::lpe
