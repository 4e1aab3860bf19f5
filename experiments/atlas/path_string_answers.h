// Determines which words of an atlas belong to which layers.
//
// A word represents one path or several: a letter may merge events (those that `--atlas-by` does not distinguish), and
// `*` is any number of scattering events from one on. The automaton of the channels moves along all these paths at
// once, as a set of states. If all states accept at the end of the word, the channel gets all of its light; if only
// some accept, the atlas cannot determine the channel's part.
//
// Channels with a technique prefix get the light that these techniques found, if the words record techniques.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "lpe/language/prefixes.h"
#include "lpe/program.h"

namespace raylex::experiments {

class PathStringAnswers {
  public:
    using Techniques = std::vector<std::optional<lpe::TechniquePrefix>>;
    /// Assigns the words of `table` to the channels of the program. `techniques` [channel] restricts channels; empty:
    /// no restriction.
    PathStringAnswers(const display::PathStringTable& table, const lpe::Program& program,
                      const Techniques& techniques = {});

    /// Channels that get all light of a word, in ascending order; and, with some(), those that may get a part of it.
    [[nodiscard]] std::span<const std::uint16_t> all(std::uint32_t word) const { return of(all_, all_begin_, word); }
    [[nodiscard]] std::span<const std::uint16_t> some(std::uint32_t word) const { return of(some_, some_begin_, word); }
    /// Returns a word of which the channel may get only a part, or -1 if the channel is exact.
    [[nodiscard]] std::int64_t undecided_path_string(std::uint16_t channel) const { return undecided_[channel]; }

  private:
    static std::span<const std::uint16_t> of(const std::vector<std::uint16_t>& list,
                                             const std::vector<std::uint32_t>& begin, std::uint32_t word) {
        return {list.data() + begin[word], list.data() + begin[word + 1]};
    }
    std::vector<std::uint16_t> all_, some_;
    std::vector<std::uint32_t> all_begin_{0}, some_begin_{0};
    std::vector<std::int64_t> undecided_;
};

/// Returns a word as text for people: "C <R.D.'floor'> ... L.'key'". Events are written as in lpe/match.h, `...` is
/// `*`, `/` separates merged events. If words record techniques, the technique follows in brackets.
std::string path_string_text(const display::PathStringTable& table, std::uint32_t word);

}  // namespace raylex::experiments
