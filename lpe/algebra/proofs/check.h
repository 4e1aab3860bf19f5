// Proofs about channels: is a set a partition of the beauty, are channels disjoint, are two expressions equal? Each
// answer is a proof over the whole automaton, or the shortest path that is a counterexample. All answers hold for W
// (lpe/path_strings.h): paths that no scene can produce never decide anything.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

enum class SplitProof { partition, missed, counted_twice, outside };

/// The shortest path that decides a question. Among paths of equal length the one with the simplest events is chosen.
struct Witness {
    std::vector<Event> events;
    std::string text;      ///< "C,- R,D,floor L,-,key", as `raylex lpe match` reads it
    std::string sentence;  ///< "camera, diffuse reflection off 'floor', light 'key'"
};

struct PartitionReport {
    SplitProof result = SplitProof::partition;
    Witness witness;                    ///< empty when the verdict is `partition`
    std::vector<std::size_t> channels;  ///< channels that accept the witness: none when missed, two or more when
                                        ///< counted twice
    std::string summary;                ///< one sentence that names the channels and the witness
    std::vector<std::string>
        warnings;  ///< e.g. where the two readings of '|' differ, with a word that tells them apart
};

/// Checks that every word of W that `beauty` accepts (all of W when absent) is accepted by exactly one channel, and
/// that no channel accepts any other word of W. Errors: a channel does not parse, carries prefixes, or is too large to
/// prove.
Result<PartitionReport> check_partition(std::span<const ChannelSource> channels,
                                        const std::optional<ChannelSource>& beauty = std::nullopt,
                                        const PathStrings& words = {});

struct DisjointReport {
    bool disjoint = true;
    Witness witness;                    ///< shortest path that two channels count
    std::vector<std::size_t> channels;  ///< channels that accept the witness
    std::string summary;
    std::vector<std::string> warnings;
};

/// Checks that no two channels accept a common word of W; the `rest` layer needs this. Errors: those of
/// check_partition().
Result<DisjointReport> check_disjoint(std::span<const ChannelSource> channels, const PathStrings& words = {});

/// The shortest word of W that exactly one of the two accepts; nothing when they are equivalent.
Result<std::optional<Witness>> find_difference(const ChannelSource& a, const ChannelSource& b,
                                               const PathStrings& words = {});

/// The shortest word of W that the channel accepts; nothing when it can never match.
Result<std::optional<Witness>> find_path_string(const ChannelSource& channel, const PathStrings& words = {});

/// The prefixes ("unoccluded", "noclamp", ...) that the expression carries, in order.
Result<std::vector<std::string>> expression_prefixes(const ChannelSource& channel);

/// The reason why the channel cannot be part of a split of the beauty: "prefix noclamp", or "user events", which no
/// word of W contains. Empty when it can be.
Result<std::string> why_no_part(const ChannelSource& channel);

/// Warnings about the reading of the expression: two readings of '|' that differ, with the shortest word that shows it,
/// and text that the dialect ignores.
Result<std::vector<std::string>> expression_warnings(const ChannelSource& channel, const PathStrings& words = {});

}  // namespace raylex::lpe
