// A set of compiled channels that grows: adding a channel compiles only that channel and reuses the automata of the
// others. An interactive session, in which an artist types one more expression, uses this.
//
// New labels need no recompilation: Program::classify gives a label that no expression names the class of all unnamed
// labels.
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

    /// Adds channels and returns the program of all channels, numbered in the order in which they were added. It
    /// accepts the same paths as Program::compile of the whole list; its tables can be up to twice as large. The event
    /// classes are new: callers classify their events again. Errors leave the set unchanged: the errors of
    /// Program::compile, and channels with `rest_of`, which depend on all other channels.
    Result<Program> add(std::span<const ChannelSource> channels);

    [[nodiscard]] std::span<const ChannelSource> channels() const;
    /// How often all channels were grouped from the start because a new channel did not fit into the existing groups.
    [[nodiscard]] std::size_t regroupings() const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace raylex::lpe
