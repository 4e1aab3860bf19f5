// Light subpaths: path strings that are read from their light end. A bidirectional integrator follows the camera
// subpath forward and grows the light subpath away from the light, so each new vertex comes before all earlier ones.
// Then it connects any path prefix with any path suffix, and computes which channels accept the whole.
//
// Each light vertex keeps a state of reversed automata: which states at the join lead to which channels. A vertex costs
// one table look-up, a join one more, whatever the lengths. The automata are prepared: for a table of Q states with R
// different suffixes, R * (classes + Q) words, bounded by ReverseOptions.
//
// The transition function of a suffix, as a map of all its states, would cost Q look-ups a vertex and Q words: the
// reversed automaton is the closed set of these maps, so that a map is a number (the subset construction on the
// reversed automaton: Rabin and Scott 1959, Brzozowski 1962). Bit-parallel automata (program_view.h) have few codes, so
// there each vertex does carry the maps themselves, composed by word operations: at most 2, 4 or 8 times as many words
// as automata of 2, 4 or 8 codes take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct ReverseOptions {
    std::size_t state_cap = 50'000;           ///< distinct ends of one table
    std::size_t byte_cap = 64 * 1024 * 1024;  ///< bytes of all reversed automata together
};

/// Reads the path strings of a program from their ends. It is immutable and usable by any number of threads; only
/// build() allocates. The program's tables must outlive it; the program object itself can move.
class ReversedProgram {
  public:
    /// Builds the reversed automata. Errors: they need more than the options allow.
    static Result<ReversedProgram> build(const ProgramView& program, const ReverseOptions& options = {});
    static Result<ReversedProgram> build(const Program& program, const ReverseOptions& options = {}) {
        return build(program.view(), options);
    }

    /// The number of States of one light subpath.
    [[nodiscard]] std::size_t word_count() const noexcept { return starts_.size(); }
    /// The state of the empty end: connected to a camera subpath it gives that subpath's own result.
    [[nodiscard]] std::span<const State> starts() const noexcept { return starts_; }
    /// Prepends an event; both states have word_count() words, `to` can be `from`. Returns false when no connection to
    /// a camera subpath can be accepted. For packed channels, which are not tested one by one, true can be wrong.
    bool prepend(const State* from, EventClass event, State* to) const noexcept;
    /// Computes a state of the program that accepts what the camera subpath followed by the light subpath accepts.
    /// `whole` has the program's word_count() words and can be `camera`. No event can follow it. Returns false when no
    /// channel accepts.
    bool connect(const State* camera, const State* light, State* whole) const noexcept;
    /// The number of states of one reversed table, for look-ahead; state 0 accepts nothing. Not for packed channels.
    [[nodiscard]] std::size_t state_count(std::size_t word) const noexcept {
        return tables_[word].outcome.size() / tables_[word].rows;
    }
    [[nodiscard]] State before(std::size_t word, EventClass event, State state) const noexcept {
        return tables_[word].next[std::size_t{state} * program_.class_count + event];
    }
    [[nodiscard]] bool accepts(std::size_t word, State camera, State light) const noexcept {
        return outcome(word, camera, light) != 0;
    }
    /// The size of the reversed automata in bytes.
    [[nodiscard]] std::size_t bytes() const noexcept;

  private:
    /// One reversed automaton; state 0 accepts nothing from any state.
    struct Table {
        State first_row = 0;         // row 1 of the forward table; rows are first_row ... first_row + rows - 2
        std::uint32_t rows = 0;      // forward states, including the dead one
        std::vector<State> next;     // [state][class]
        std::vector<State> outcome;  // [state][row]: a forward state that accepts what the state after the end accepts
                                     // (for the phase: that state itself); 0 for none
    };
    struct Builder;

    [[nodiscard]] const Table& table(std::size_t g) const { return g < tables_.size() ? tables_[g] : phase_; }
    [[nodiscard]] State outcome(std::size_t g, State camera, State light) const noexcept {
        const Table& reversed = table(g);
        const std::size_t row = camera == 0 ? 0 : camera - reversed.first_row + 1;
        return reversed.outcome[std::size_t{light} * reversed.rows + row];
    }

    ProgramView program_;
    std::vector<Table> tables_;
    Table phase_;
    std::vector<State> starts_;
    std::vector<std::uint8_t> zero_accepts_;  // [terminal] a packed channel accepts in code 0
};

}  // namespace raylex::lpe
