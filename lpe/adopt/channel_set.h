// Channels that come one after the other: adding one to a compiled set compiles that one and keeps the automata of the
// others (an interactive session in which an artist types one more expression, say).
//
// New labels need nothing of this: Program::classify puts a label that no expression names where all such labels are.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

class ChannelSet {
  public:
    explicit ChannelSet(const CompileOptions& options = {});
    ~ChannelSet();
    ChannelSet(ChannelSet&&) noexcept;
    ChannelSet& operator=(ChannelSet&&) noexcept;

    /// Adds channels and returns the program of all, numbered in the order in which they came. It accepts what
    /// Program::compile of the whole list would, from tables that may be up to twice as large. Event classes are new:
    /// events are to be classified again. Errors, after which the set is what it was: those of Program::compile;
    /// channels with `rest_of`, which depend on all others.
    Result<Program> add(std::span<const ChannelSource> channels);

    [[nodiscard]] std::span<const ChannelSource> channels() const;
    /// How often the channels were grouped from the start because one more did not fit what was there.
    [[nodiscard]] std::size_t regroupings() const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace raylex::lpe
