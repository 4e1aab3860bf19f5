// The compiled form of a set of channels: plain tables that match path events for all channels at once.
//
// A Program is one minimised deterministic automaton per group of channels; nearly always there is one group. States
// are numbered globally over all groups, so a matcher carries just a list of states, one per group, and every table
// look-up is `next_state[state * class_count + event_class]`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::lpe {

using State = std::uint32_t;
using EventClass = std::uint16_t;

/// A channel as the compiler takes it. `expression` may carry prefixes ("unoccluded;...") and the "lpe:" mark.
struct ChannelSource {
    std::string name{};
    std::string expression{};
    Dialect dialect = Dialect::renderman;
    std::string origin{};          ///< for errors: the file or option the text stands in
    int origin_line = 0;           ///< line of the expression's first character in `origin`, 0 if it has none
    int origin_column = 0;
    /// When not empty this channel has no expression of its own: it accepts every word of W (lpe/words.h) that none of
    /// these channels (indices into the list being compiled) accepts.
    std::vector<std::size_t> rest_of{};
};

struct CompileOptions {
    std::size_t state_cap = 50'000;  ///< states of one group before channels are spread over more groups; one channel
                                     ///< alone may have more, up to a fixed bound
    std::size_t group_cap = 8;       ///< groups before compilation is refused with a message naming the channels
    /// Renderers report words of the form C (R | T | V | user)* (L | B | O), so that is all a Program tells apart: the
    /// tables are several times smaller and a state is dead as soon as no such word can be completed. Set this to follow
    /// the expressions through any sequence of events whatever (conformance vectors do).
    bool any_word = false;
};

class Program {
  public:
    static constexpr State dead = 0;  ///< the one state, shared by all groups, from which nothing can be accepted

    Program();
    ~Program();
    Program(Program&&) noexcept;
    Program& operator=(Program&&) noexcept;
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    static Result<Program> compile(std::span<const ChannelSource> channels, const CompileOptions& options = {});

    /// The column of the transition table that `event` selects. Not for the inner loop: ask once per kind of event.
    [[nodiscard]] EventClass classify(const Event& event) const;

    /// One start state per group, before the camera event.
    [[nodiscard]] std::span<const State> starts() const noexcept { return starts_; }
    [[nodiscard]] State next(State state, EventClass event) const noexcept {
        return next_state_[static_cast<std::size_t>(state) * class_count_ + event];
    }
    /// Channels (indices into the compiled list, ascending) whose expression accepts the word read so far.
    [[nodiscard]] std::span<const std::uint16_t> accepted(State state) const noexcept {
        return {accept_lists_.data() + accept_begin_[state], accept_lists_.data() + accept_begin_[state + 1]};
    }
    [[nodiscard]] bool accepts_any(State state) const noexcept {
        return accept_begin_[state] != accept_begin_[state + 1];
    }
    [[nodiscard]] std::size_t state_count() const noexcept { return accept_begin_.empty() ? 0 : accept_begin_.size() - 1; }
    [[nodiscard]] std::size_t class_count() const noexcept { return class_count_; }
    [[nodiscard]] std::size_t group_count() const noexcept { return starts_.size(); }

  private:
    friend class ProgramBuilder;
    struct Classifier;
    std::vector<State> starts_;
    std::size_t class_count_ = 0;
    std::vector<State> next_state_;             // [state][event class]
    std::vector<std::uint32_t> accept_begin_;   // [state + 1], offsets into accept_lists_
    std::vector<std::uint16_t> accept_lists_;
    std::unique_ptr<Classifier> classifier_;
};

}  // namespace raylex::lpe
