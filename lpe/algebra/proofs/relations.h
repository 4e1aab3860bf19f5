// How languages stand to one another: coverage, equality, containment, emptiness. Every answer is a proof over W
// (lpe/words.h) or comes with the shortest path that shows the contrary. Channels may be of different dialects;
// prefixes change what is splatted and not which paths match, so they play no part here.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

struct Proof {
    bool holds = true;
    Witness witness;                    ///< the shortest path against it; empty when it holds
    std::vector<std::size_t> channels;  ///< of those asked about, which accept the witness
    std::string summary;                ///< one sentence for people, channels named, witness included
    std::vector<std::string> warnings;  ///< about how the expressions were read
};

// Errors of all: an expression that does not parse, or is too large to prove.

/// Whether every path of W that `beauty` accepts (all of W when absent) is accepted by at least one channel.
Result<Proof> check_covers(std::span<const ChannelSource> channels,
                           const std::optional<ChannelSource>& beauty = std::nullopt, const Words& words = {});

/// Whether all channels accept the same paths of W.
Result<Proof> check_equal(std::span<const ChannelSource> channels, const Words& words = {});

/// Whether `outer` accepts every path of W that `inner` does.
Result<Proof> check_contains(const ChannelSource& outer, const ChannelSource& inner, const Words& words = {});

/// Whether the channel accepts no path of W.
Result<Proof> check_empty(const ChannelSource& channel, const Words& words = {});

/// Whether the expression, however it is written, accepts every path of W and has no prefixes, so that its channel is
/// the beauty.
Result<bool> is_beauty(const ChannelSource& expression, const Words& words = {});

}  // namespace raylex::lpe
