// Light subpaths: words that are known from their far end. A bidirectional integrator follows the camera subpath forward
// and grows the light subpath away from the light, each new vertex standing before all that were read; then it joins any
// prefix of the one with any end of the other and asks which channels accept the whole.
//
// Two ways, with the same answers (tests/lpe/reversal_test.cpp):
//
//   LightWord          keeps the event classes of the light subpath and replays them at a join. 2 bytes a vertex; a join
//                      costs one forward move an event (some 2 ns in one table). Needs nothing prepared and fits every
//                      program. With subpaths of up to about ten vertices it is the cheaper way, and never wrong.
//   ReversedProgram    each light vertex keeps a state of reversed automata: which states at the join lead to which
//                      channels. A vertex costs one table look-up, a join one more, whatever the length. It can also say
//                      that no camera subpath makes anything of a light subpath (Law 4). The automata are prepared: for a
//                      table of Q states with R ends that differ, R * (classes + Q) words; that is bounded by
//                      ReverseOptions, and where a program passes the bound, replay.
//
// An automaton's transition function of an end, as a map of all its states, would cost Q look-ups a vertex and Q words:
// the reversed automaton is the closed set of these maps, so that a map is a number. Packed channels (program_view.h) have
// few codes, so there each vertex does carry the maps themselves, composed by word operations: at most 2, 4 or 8 times as
// many words as the lanes of 2, 4 or 8 codes take.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// A light subpath as its events, read from the light: no heap, copied freely.
class LightWord {
  public:
    static constexpr std::size_t capacity = 62;

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    /// Puts an event before all that were read (the terminal comes first). False, and nothing done, when it is full.
    bool prepend(EventClass event) noexcept {
        if (size_ == capacity) {
            return false;
        }
        events_[size_++] = event;
        return true;
    }
    /// Forgets all but the first `size` events that were read.
    void cut(std::size_t size) noexcept { size_ = size < size_ ? static_cast<std::uint16_t>(size) : size_; }
    /// The state after a camera subpath in state `camera` and the last-read `count` events down to the terminal: all of
    /// them unless told otherwise. Both states have word_count() words; false when no channel accepts.
    bool join(const Program& program, const State* camera, State* whole) const noexcept { return join(program, camera, size_, whole); }
    bool join(const Program& program, const State* camera, std::size_t count, State* whole) const noexcept {
        for (std::size_t word = 0; word < program.word_count(); ++word) {
            whole[word] = camera[word];
        }
        bool alive = true;
        while (count > 0 && alive) {
            alive = program.advance(whole, events_[--count], whole);
        }
        return alive;
    }

  private:
    std::uint16_t size_ = 0;
    std::array<EventClass, capacity> events_;  // [0] is the terminal
};

struct ReverseOptions {
    std::size_t state_cap = 50'000;           ///< ends that one table may tell apart
    std::size_t byte_cap = 64 * 1024 * 1024;  ///< of all reversed automata together
};

/// Reads words of a program from their ends. Immutable, for any number of threads; nothing but build() allocates. The
/// program must outlive it and stay where it is.
class ReversedProgram {
  public:
    /// Errors: the program needs more than the options allow (join by LightWord then).
    static Result<ReversedProgram> build(const Program& program, const ReverseOptions& options = {});

    /// States of one light subpath.
    [[nodiscard]] std::size_t word_count() const noexcept { return starts_.size(); }
    /// The state of the empty end: joined with a camera subpath it gives what that subpath alone gives.
    [[nodiscard]] std::span<const State> starts() const noexcept { return starts_; }
    /// Puts an event before all that were read; word_count() words each, `to` may be `from`. False when no camera subpath
    /// can be joined so that a channel accepts. (Packed channels are not asked one by one: true may be in vain for them.)
    bool prepend(const State* from, EventClass event, State* to) const noexcept;
    /// Calls visit(channel) for each channel that accepts the camera subpath followed by the light subpath.
    template <class Visit>
    void for_each_accepted(const State* camera, const State* light, Visit&& visit) const {
        const ProgramView& program = program_->view();
        for (std::size_t g = 0; g < tables_.size(); ++g) {
            const std::uint32_t list = outcome(g, camera[g], light[g]);
            for (std::uint32_t i = list_begin_[list]; i < list_begin_[list + 1]; ++i) {
                visit(lists_[i]);
            }
        }
        if (!program.has_lanes()) {
            return;
        }
        const std::size_t phase = tables_.size();
        std::array<State, most_lane_words + 1> ended;
        ended[0] = camera[phase] == 0 ? 0 : outcome(phase, camera[phase], light[phase]);
        if (ended[0] >= program.first_ended) {
            program.move_lanes(camera + phase + 1, light + phase + 1, ~0U, ended.data() + 1);
            program.visit_ended(ended.data(), visit);
        }
    }
    [[nodiscard]] bool accepts_any(const State* camera, const State* light) const {
        bool any = false;
        for_each_accepted(camera, light, [&any](std::uint16_t) { any = true; });
        return any;
    }
    /// Bytes of the reversed automata.
    [[nodiscard]] std::size_t bytes() const noexcept;

  private:
    static constexpr std::size_t most_lane_words = 256;
    /// One reversed automaton; state 0 is the end that no state makes anything of.
    struct Table {
        State first_row = 0;              // row 1 of the forward table; rows are first_row ... first_row + rows - 2
        std::uint32_t rows = 0;           // forward states, the dead one included
        std::vector<State> next;          // [state][class]
        std::vector<std::uint32_t> outcome;  // [state][row]: accept list, or for the phase the phase after the end
    };
    struct Builder;

    [[nodiscard]] const Table& table(std::size_t g) const { return g < tables_.size() ? tables_[g] : phase_; }
    [[nodiscard]] std::uint32_t outcome(std::size_t g, State camera, State light) const noexcept {
        const Table& reversed = table(g);
        const std::size_t row = camera == 0 ? 0 : camera - reversed.first_row + 1;
        return reversed.outcome[std::size_t{light} * reversed.rows + row];
    }

    const Program* program_ = nullptr;
    std::vector<Table> tables_;
    Table phase_;
    std::vector<State> starts_;
    std::vector<std::uint32_t> list_begin_{0, 0};
    std::vector<std::uint16_t> lists_;
};

}  // namespace raylex::lpe
