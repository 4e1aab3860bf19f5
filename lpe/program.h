// The compiled form of a set of channels: plain tables that match path events for all channels at once.
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

#include "lpe/event.h"
#include "lpe/program_tables.h"
#include "lpe/program_view.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct SourceMap;  // lpe/language/source_map.h
class Vocabulary;  // lpe/adopt/vocabulary.h

/// A channel as the compiler takes it. `expression` may carry prefixes ("unoccluded;...") and the "lpe:" mark.
struct ChannelSource {
    std::string name{};
    std::string expression{};
    Dialect dialect = Dialect::renderman;
    std::string origin{};  ///< for errors: the file or option the text stands in
    int origin_line = 0;   ///< line of the expression's first character in `origin`, 0 if it has none
    int origin_column = 0;
    /// When not empty this channel has no expression of its own: it accepts every word of W (lpe/words.h) that none of
    /// these channels (indices into the list being compiled) accepts.
    std::vector<std::size_t> rest_of{};
    /// Where each byte of the expression came from, when that is more than one place in one line (escapes, macros);
    /// errors then point there and `origin` only names the whole.
    std::shared_ptr<const SourceMap> map{};
    /// Names of a renderer's own events and lobes that the expression may use.
    std::shared_ptr<const Vocabulary> vocabulary{};
};

struct CompileOptions {
    std::size_t state_cap = 50'000;  ///< states of one group before channels are spread over more groups; one channel
                                     ///< alone may have more, up to a fixed bound
    std::size_t group_cap = 8;       ///< groups before compilation is refused with a message naming the channels
    std::size_t word_cap = 32;       ///< words of a path's state: groups, and the words of packed channels
    /// Renderers report words of the form C (R | T | V | user)* (L | B | O), so that is all a Program tells apart: the
    /// tables are several times smaller and a state is dead as soon as no such word can be completed. Set this to
    /// follow the expressions through any sequence of events whatever (conformance vectors do).
    bool any_word = false;
};

class Program {
  public:
    static constexpr State dead = ProgramView::dead;  ///< the one table state from which nothing can be accepted

    /// The program of no channels.
    Program();
    /// From tables that are known to be whole (adopt/program_file.h checks those of a file).
    explicit Program(ProgramTables tables) : tables_(std::move(tables)), view_(tables_.view()) {}
    Program(Program&&) noexcept = default;
    Program& operator=(Program&&) noexcept = default;
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    static Result<Program> compile(std::span<const ChannelSource> channels, const CompileOptions& options = {});

    /// The same automaton over other columns: column k moves as `columns[k]` does here. For callers that tell apart
    /// what no channel does, and classify events themselves: classify() then knows nothing of the columns.
    [[nodiscard]] Program with_columns(std::span<const EventClass> columns) const;

    /// The column of the transition table that `event` selects. Not for the inner loop: ask once per kind of event. New
    /// labels need no new program: one that no expression names is of the class of all such labels.
    [[nodiscard]] EventClass classify(const Event& event) const;

    /// Whether some path that can still be accepted may be so after an event of this class. Not for the inner loop.
    [[nodiscard]] bool follows(EventClass event) const;

    /// Words of a path's state.
    [[nodiscard]] std::size_t word_count() const noexcept { return view_.word_count; }
    /// The state before the camera event.
    [[nodiscard]] std::span<const State> starts() const noexcept { return tables_.starts; }
    /// Moves one path along one event; both have word_count() words, `to` may be `from`. False when no channel can
    /// accept any more, now or after any further events.
    bool advance(const State* from, EventClass event, State* to) const noexcept {
        return view_.advance(from, event, to);
    }
    /// Calls visit(channel) for every channel (index into the compiled list) whose expression accepts the word read so
    /// far.
    template <class Visit>
    void for_each_accepted(const State* states, Visit&& visit) const {
        view_.for_each_accepted(states, visit);
    }
    [[nodiscard]] bool accepts_any_of(const State* states) const noexcept { return view_.accepts_any(states); }

    /// Many paths at once, states[path][word], each moved along its own event in place.
    void advance(std::span<State> states, std::span<const EventClass> events) const noexcept;
    /// Many paths at once: bit `channel` of masks[path][mask_words()] is set where that channel accepts, all others are
    /// cleared.
    void accepts(std::span<const State> states, std::span<std::uint32_t> masks) const noexcept;
    [[nodiscard]] std::size_t mask_words() const noexcept { return (view_.channel_count + 31) / 32; }

    // The words that are table rows, one by one: all of them where !view().has_parallel(), as always with
    // CompileOptions::any_word and with one channel.
    [[nodiscard]] State next(State state, EventClass event) const noexcept { return view_.next(state, event); }
    /// Ascending.
    [[nodiscard]] std::span<const std::uint16_t> accepted(State state) const noexcept { return view_.accepted(state); }
    [[nodiscard]] bool accepts_any(State state) const noexcept { return !accepted(state).empty(); }

    [[nodiscard]] std::size_t state_count() const noexcept { return view_.state_count; }
    [[nodiscard]] std::size_t class_count() const noexcept { return view_.class_count; }
    /// The same as word_count(): one word per group of channels, plus those of packed channels.
    [[nodiscard]] std::size_t group_count() const noexcept { return view_.word_count; }
    [[nodiscard]] std::size_t channel_count() const noexcept { return view_.channel_count; }

    /// As plain data; valid as long as this program is.
    [[nodiscard]] const ProgramView& view() const noexcept { return view_; }
    [[nodiscard]] const ProgramTables& tables() const noexcept { return tables_; }

  private:
    ProgramTables tables_;
    ProgramView view_;  // into tables_, whose arrays stay where they are when a program moves
};

}  // namespace raylex::lpe
