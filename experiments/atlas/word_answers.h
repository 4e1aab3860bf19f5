// Which layers the words of an atlas are light of.
//
// A word of an atlas stands for one path's events, or for several: letters that merge events (what `--atlas-by` left
// out), and `*` for one scattering or more. The channels' automaton is moved along all of them at once, as a set of
// states. Where all states at the word's end accept, all its light is the channel's; where some do, the atlas cannot
// say how much of it is.
//
// Channels whose prefix names techniques take what these found, of atlases whose words tell.
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

class WordAnswers {
  public:
    using Techniques = std::vector<std::optional<lpe::TechniquePrefix>>;
    /// What the words of `table` are to the program's channels; `techniques` [channel], all of them where it is empty.
    WordAnswers(const display::WordTable& table, const lpe::Program& program, const Techniques& techniques = {});

    /// Channels that take all light of a word, and those that may take some of it; ascending.
    [[nodiscard]] std::span<const std::uint16_t> all(std::uint32_t word) const { return of(all_, all_begin_, word); }
    [[nodiscard]] std::span<const std::uint16_t> some(std::uint32_t word) const { return of(some_, some_begin_, word); }
    /// A word of which a channel may take some, or -1: whether the atlas answers it exactly.
    [[nodiscard]] std::int64_t undecided_word(std::uint16_t channel) const { return undecided_[channel]; }

  private:
    static std::span<const std::uint16_t> of(const std::vector<std::uint16_t>& list,
                                             const std::vector<std::uint32_t>& begin, std::uint32_t word) {
        return {list.data() + begin[word], list.data() + begin[word + 1]};
    }
    std::vector<std::uint16_t> all_, some_;
    std::vector<std::uint32_t> all_begin_{0}, some_begin_{0};
    std::vector<std::int64_t> undecided_;
};

/// A word as people read it: "C <R.D.'floor'> ... L.'key'": events as lpe/match.h writes them, `...` for `*`, `/`
/// between events that were not told apart, and how its light was found, in brackets, where words tell.
std::string word_text(const display::WordTable& table, std::uint32_t word);

}  // namespace raylex::experiments
