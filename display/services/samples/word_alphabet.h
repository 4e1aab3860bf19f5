// The letters of words that a path atlas keeps: what of a scene's events is told apart, and words as numbers.
//
// An atlas keeps the light of every distinct word, so its letters are the scene's own events, told apart as far as the
// user asks: by object label, by lobe, by light group. Every event of the scene is a column; columns that are told
// apart in nothing that is kept share a letter, and whoever reads the atlas learns which events a letter stands for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "lpe/event.h"
#include "lpe/program_view.h"
#include "lpe/result.h"

namespace raylex::display {

/// "s1t3".
inline std::string to_string(const Technique& technique) {
    return "s" + std::to_string(technique.s) + "t" + std::to_string(technique.t);
}

/// What words are told apart by, and how long they get.
struct WordRules {
    bool labels = true;       ///< of objects and media
    bool lobes = true;        ///< names and numbers of lobes; type and scatter letter always are
    bool groups = true;       ///< of lights; L, B and O always are
    bool straight = false;    ///< light straight through cutouts, which only the osl dialect sees
    bool techniques = false;  ///< how light was found, which no expression sees but by its prefix
    static constexpr int most_length = 1000;
    int length = 8;  ///< scatterings of the longest word kept whole
};

/// "label,lobe,group,straight,technique", any of them. Errors at `where`.
Result<WordRules> parse_word_rules(const std::string& text, const SourceLocation& where);
/// What parse_word_rules() reads; empty where words are told apart by nothing but types.
[[nodiscard]] std::string to_string(const WordRules& rules);

class WordAlphabet {
  public:
    using Letter = std::uint16_t;
    /// Takes the place of one scattering or more, whatever they are: words beyond the length, and merged ones.
    static constexpr Letter open = 0xffff;
    /// Techniques are letters as well, behind the terminal, where words are told apart by them: from this one on.
    static constexpr Letter first_technique = 0x8000;
    /// A technique's s or t is known up to this, which stands for itself and whatever is more.
    static constexpr std::uint32_t most_vertices = 127;
    [[nodiscard]] static bool is_technique(Letter letter) { return letter >= first_technique && letter != open; }
    [[nodiscard]] static Letter letter_of(Technique technique) {
        const std::uint32_t s = std::min(technique.s, most_vertices), t = std::min(technique.t, most_vertices);
        return static_cast<Letter>(first_technique + s * (most_vertices + 1) + t);
    }
    [[nodiscard]] static Technique technique_of(Letter letter) {
        const std::uint32_t number = letter - std::uint32_t{first_technique};
        return {number / (most_vertices + 1), number % (most_vertices + 1)};
    }
    enum class Kind : std::uint8_t { scattering, straight, terminal };

    /// `events`: what the scene can produce, without the camera's. Errors: more than an automaton has columns for.
    static Result<WordAlphabet> build(std::span<const lpe::Event> events, const WordRules& rules);

    /// Column 0 is no event of the scene: it stands for any scattering.
    [[nodiscard]] lpe::EventClass column(const lpe::Event& event) const;
    [[nodiscard]] std::size_t column_count() const { return events_.size(); }
    [[nodiscard]] const lpe::Event& event(std::size_t column) const { return events_[column]; }
    [[nodiscard]] Letter letter(std::size_t column) const { return letters_[column]; }
    [[nodiscard]] Kind kind(std::size_t column) const { return kinds_[column]; }
    [[nodiscard]] std::size_t letter_count() const { return letter_count_; }
    [[nodiscard]] const WordRules& rules() const { return rules_; }

  private:
    std::map<std::string, lpe::EventClass> columns_;
    std::vector<lpe::Event> events_;
    std::vector<Letter> letters_;
    std::vector<Kind> kinds_;
    std::size_t letter_count_ = 0;
    WordRules rules_;
};

/// Words as numbers: the prefixes of all that came up, each by the one before it and a letter more.
class WordTree {
  public:
    using Letter = WordAlphabet::Letter;
    static constexpr std::uint32_t root = 0;  ///< the camera alone
    struct Node {
        std::uint32_t parent = root;
        Letter letter = 0;
        std::uint16_t before = 0;  ///< letters before this one
    };

    WordTree();
    /// The word of one letter more; a new one gets the next number.
    std::uint32_t child(std::uint32_t parent, Letter letter);
    [[nodiscard]] const Node& node(std::uint32_t word) const { return nodes_[word]; }
    [[nodiscard]] std::size_t size() const { return nodes_.size(); }
    [[nodiscard]] std::size_t letters_in(std::uint32_t word) const {
        return word == root ? 0 : std::size_t{nodes_[word].before} + 1;
    }
    /// Letters from the camera on.
    [[nodiscard]] std::vector<Letter> letters(std::uint32_t word) const;
    [[nodiscard]] std::size_t memory_bytes() const {
        return nodes_.capacity() * sizeof(Node) + sizeof(Slot) * slots_.size();
    }

  private:
    struct Slot {
        std::uint32_t parent = root, word = root;  // word: the root where the slot is free, for it is nobody's child
        Letter letter = 0;
    };
    void grow();
    [[nodiscard]] std::size_t slot_of(std::uint32_t parent, Letter letter) const;
    std::vector<Node> nodes_;
    std::vector<Slot> slots_;  // open addressing, a power of two
};

}  // namespace raylex::display
