// The algebra's verdicts: is a set of channels a partition of the beauty, are channels disjoint, are two expressions
// the same? Each answer is a proof by exhausting an automaton, or the shortest path that shows the contrary. All are
// relative to W (lpe/words.h): paths that no scene can produce never decide anything.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

enum class Verdict { partition, missed, counted_twice, outside };

/// A path that decides a question, shortest first; ties go to the plainest event.
struct Witness {
    std::vector<Event> events;
    std::string text;      ///< "C,- R,D,floor L,-,key", as `raylex lpe match` reads it
    std::string sentence;  ///< "camera, diffuse reflection off 'floor', light 'key'"
};

struct PartitionReport {
    Verdict verdict = Verdict::partition;
    Witness witness;                    ///< empty when the verdict is `partition`
    std::vector<std::size_t> channels;  ///< that accept the witness: none when missed, two or more when counted twice
    std::string summary;                ///< one sentence for people, channels named, witness included
    std::vector<std::string>
        warnings;  ///< e.g. where the two readings of '|' differ, with a word that tells them apart
};

/// Whether every word of W that `beauty` accepts (all of W when absent) is accepted by exactly one channel and no
/// channel accepts another word of W. Errors: a channel that does not parse, carries prefixes, or is too large to
/// prove.
Result<PartitionReport> check_partition(std::span<const ChannelSource> channels,
                                        const std::optional<ChannelSource>& beauty = std::nullopt,
                                        const Words& words = {});

struct DisjointReport {
    bool disjoint = true;
    Witness witness;                    ///< shortest path that two channels count
    std::vector<std::size_t> channels;  ///< that accept the witness
    std::string summary;
    std::vector<std::string> warnings;
};

/// Whether no word of W is accepted by two of the channels. For the automatic `rest` layer. Errors as above.
Result<DisjointReport> check_disjoint(std::span<const ChannelSource> channels, const Words& words = {});

/// The shortest word of W that one of the two accepts and the other does not; nothing when they are equivalent.
Result<std::optional<Witness>> find_difference(const ChannelSource& a, const ChannelSource& b, const Words& words = {});

/// The shortest word of W that the channel accepts; nothing when it can never match.
Result<std::optional<Witness>> find_word(const ChannelSource& channel, const Words& words = {});

/// The prefixes ("unoccluded", "noclamp", ...) that the expression carries, in order.
Result<std::vector<std::string>> expression_prefixes(const ChannelSource& channel);

/// What keeps the channel out of every split of the beauty: "prefix noclamp", "user events" (which no word of W
/// has), or nothing.
Result<std::string> why_no_part(const ChannelSource& channel);

/// Warnings about how the expression was read: readings of '|' that differ (with the shortest word that tells them
/// apart), text the dialect ignores.
Result<std::vector<std::string>> expression_warnings(const ChannelSource& channel, const Words& words = {});

}  // namespace raylex::lpe
