// Several channels as automata over common event classes. The compiler and the algebra both start from them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/automata/dfa.h"
#include "lpe/language/ast.h"
#include "lpe/language/event_classes.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"

namespace raylex::lpe {

struct Languages {
    std::unique_ptr<EventClasses> classes;
    std::vector<Dfa> channels;  ///< minimal, output 1 where the channel accepts
    std::optional<Dfa> words;   ///< W, when requested
};

struct LanguageOptions {
    std::size_t state_cap = 50'000;
    const PathStrings* words = nullptr;  ///< restrict W to these, and build it too
    /// Leaves labels that OSL's wildcards refuse (named "D", "x", ...) out of W. Proofs about osl channels need this;
    /// otherwise no channel could equal the beauty.
    bool skip_reserved_labels = false;
    BarReading bar = BarReading::tight;
    bool renderer_path_strings = false;  ///< restrict every channel to the words that a renderer can report
};

/// Parses every channel and builds its automaton. A channel with `rest_of` gets W minus the union of those channels.
/// Throws Failure that names the channel.
[[nodiscard]] Languages build_languages(std::span<const ChannelSource> channels, const LanguageOptions& options);
/// Builds the automata of parsed channels: one tree per channel, null for channels with `rest_of`.
[[nodiscard]] Languages build_languages(std::span<const ChannelSource> channels, std::span<Expression> expressions,
                                        const LanguageOptions& options);

/// Joins the automata pairwise in a balanced tree with `combination`, and minimises after each step. Throws Failure
/// with `what` in its message if the result needs more than `state_cap` states.
[[nodiscard]] Dfa joined(std::span<const Dfa* const> dfas, const Combination& combination, std::size_t state_cap,
                         std::size_t class_count, const std::string& what);

/// The event sets of W: camera, scattering, terminals.
struct PathStringSets {
    EventSet camera, scattering, terminal;
    EventSet straight;             ///< with max_depth: events that do not count; `scattering` has none of them
    std::optional<int> max_depth;  ///< limit on repetitions of `scattering`
};
/// The event sets of W. If W has an alphabet, only one of several events is listed that all sets in `distinguished`
/// treat alike, because a proof cannot distinguish them.
[[nodiscard]] PathStringSets path_string_sets(const PathStrings& words, bool skip_reserved_labels,
                                              std::span<const EventSet> distinguished = {});
/// All words that a renderer can report, with user events and with any labels and lobe numbers.
[[nodiscard]] PathStringSets renderer_path_string_sets();

}  // namespace raylex::lpe
