// Relations between languages: coverage, equality, containment, emptiness. Every answer is a proof over W
// (lpe/path_strings.h), or comes with the shortest counterexample. Channels can be of different dialects. Prefixes
// change what is splatted and not which paths match, so these checks ignore them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct Proof {
    bool holds = true;
    Witness witness;                    ///< the shortest counterexample; empty when the relation holds
    std::vector<std::size_t> channels;  ///< the requested channels that accept the witness
    std::string summary;                ///< one sentence that names the channels and the witness
    std::vector<std::string> warnings;  ///< about how the expressions were parsed
};

// Errors of all functions below: an expression does not parse, or is too large to prove.

/// Checks that every path of W that `beauty` accepts (all of W when absent) is accepted by at least one channel.
Result<Proof> check_covers(std::span<const ChannelSource> channels,
                           const std::optional<ChannelSource>& beauty = std::nullopt, const PathStrings& words = {});

/// Checks that all channels accept the same paths of W.
Result<Proof> check_equal(std::span<const ChannelSource> channels, const PathStrings& words = {});

/// Checks that `outer` accepts every path of W that `inner` accepts.
Result<Proof> check_contains(const ChannelSource& outer, const ChannelSource& inner, const PathStrings& words = {});

/// Checks that the channel accepts no path of W.
Result<Proof> check_empty(const ChannelSource& channel, const PathStrings& words = {});

/// Returns whether the expression, in whatever form, accepts every path of W and has no prefixes. Its channel then is
/// the beauty.
Result<bool> is_beauty(const ChannelSource& expression, const PathStrings& words = {});

}  // namespace raylex::lpe
