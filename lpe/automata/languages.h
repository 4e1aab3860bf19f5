// Several channels as automata over common event classes: the meeting point of the compiler and the algebra.
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
#include "lpe/program.h"
#include "lpe/words.h"

namespace raylex::lpe {

struct Languages {
    std::unique_ptr<EventClasses> classes;
    std::vector<Dfa> channels;  ///< minimal, output 1 where the channel accepts
    std::optional<Dfa> words;   ///< W, when asked for
};

struct LanguageOptions {
    std::size_t state_cap = 50'000;
    const Words* words = nullptr;  ///< build W too, cut to this
    /// Leave labels that OSL's wildcards refuse (named "D", "x", ...) out of W. Proofs about osl channels do: no
    /// channel could ever be a beauty otherwise.
    bool skip_reserved_labels = false;
    BarReading bar = BarReading::tight;
    bool renderer_words = false;  ///< cut every channel to CompileOptions' words of a renderer
};

/// Parses and determinises every channel. Channels with `rest_of` get W minus the union of those channels. Throws
/// Failure that names the channel.
[[nodiscard]] Languages build_languages(std::span<const ChannelSource> channels, const LanguageOptions& options);
/// The same for channels that were parsed already; one tree per channel, null for those with `rest_of`.
[[nodiscard]] Languages build_languages(std::span<const ChannelSource> channels, std::span<Expression> expressions,
                                        const LanguageOptions& options);

/// One automaton for all of them: outputs joined by `combination` in a balanced tree, minimised on the way. Throws
/// Failure with `what` in its message when it would take more than `state_cap` states.
[[nodiscard]] Dfa joined(std::span<const Dfa* const> dfas, const Combination& combination, std::size_t state_cap,
                         std::size_t class_count, const std::string& what);

/// The event sets of W: camera, scattering, terminals.
struct WordSets {
    EventSet camera, scattering, terminal;
    EventSet straight;             ///< with max_depth: the events that do not count, then none of `scattering`
    std::optional<int> max_depth;  ///< repetitions of `scattering`
};
/// Of an alphabet's events that all of `told_apart` answer alike, the first alone is listed: nothing else could tell
/// them apart in a proof.
[[nodiscard]] WordSets word_sets(const Words& words, bool skip_reserved_labels,
                                 std::span<const EventSet> told_apart = {});
/// Words that a renderer can report, user events included, labels and lobe numbers at will.
[[nodiscard]] WordSets renderer_word_sets();

}  // namespace raylex::lpe
