// The letters of path strings in a path atlas: the events of a scene, as far as they are distinguished. Path strings
// are stored as numbers.
//
// An atlas keeps the light of every distinct path string. Its letters are the scene's events, distinguished as the user
// requests: by object label, lobe, light group. Every event of the scene is a column. Columns that differ only in
// properties that are not kept share a letter, and the atlas lists the events of each letter.
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

/// The technique as text: "s1t3".
inline std::string to_string(const Technique& technique) {
    return "s" + std::to_string(technique.s) + "t" + std::to_string(technique.t);
}

/// The properties that distinguish path strings, and the maximum length of path strings.
struct PathStringRules {
    bool labels = true;       ///< labels of objects and media
    bool lobes = true;        ///< names and numbers of lobes; type and scatter letter always distinguish words
    bool groups = true;       ///< groups of lights; L, B and O always distinguish words
    bool straight = false;    ///< pass-through events at cutouts, which only the osl dialect has
    bool techniques = false;  ///< how light was found, which expressions can only select by a prefix
    static constexpr int most_length = 1000;
    int length = 8;  ///< scatterings of the longest path string that is stored completely
};

/// Parses a list of "label", "lobe", "group", "straight" and "technique", separated by commas. Errors are at `where`.
Result<PathStringRules> parse_path_string_rules(const std::string& text, const SourceLocation& where);
/// The text that parse_path_string_rules() parses; empty if only types distinguish words.
[[nodiscard]] std::string to_string(const PathStringRules& rules);

class PathAlphabet {
  public:
    using Letter = std::uint16_t;
    /// Represents one or more arbitrary scatterings: in path strings beyond the maximum length, and in merged ones.
    static constexpr Letter open = 0xffff;
    /// The first letter for techniques, which follow the terminal if techniques distinguish path strings.
    static constexpr Letter first_technique = 0x8000;
    /// The largest s or t of a technique that is distinguished; larger ones count as this.
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

    /// `events`: the events that the scene can produce, without the camera's. Errors: more events than an automaton's
    /// columns.
    static Result<PathAlphabet> build(std::span<const lpe::Event> events, const PathStringRules& rules);

    /// The column of an event. Column 0 is not an event of the scene; it represents any scattering.
    [[nodiscard]] lpe::EventClass column(const lpe::Event& event) const;
    [[nodiscard]] std::size_t column_count() const { return events_.size(); }
    [[nodiscard]] const lpe::Event& event(std::size_t column) const { return events_[column]; }
    [[nodiscard]] Letter letter(std::size_t column) const { return letters_[column]; }
    [[nodiscard]] Kind kind(std::size_t column) const { return kinds_[column]; }
    [[nodiscard]] std::size_t letter_count() const { return letter_count_; }
    [[nodiscard]] const PathStringRules& rules() const { return rules_; }

  private:
    std::map<std::string, lpe::EventClass> columns_;
    std::vector<lpe::Event> events_;
    std::vector<Letter> letters_;
    std::vector<Kind> kinds_;
    std::size_t letter_count_ = 0;
    PathStringRules rules_;
};

/// Path strings as numbers: all prefixes that occurred, each as its parent and one more letter.
class PathStringTree {
  public:
    using Letter = PathAlphabet::Letter;
    static constexpr std::uint32_t root = 0;  ///< the camera alone
    struct Node {
        std::uint32_t parent = root;
        Letter letter = 0;
        std::uint16_t before = 0;  ///< number of letters before this one
    };

    PathStringTree();
    /// The path string with one more letter; a new path string gets the next number.
    std::uint32_t child(std::uint32_t parent, Letter letter);
    [[nodiscard]] const Node& node(std::uint32_t word) const { return nodes_[word]; }
    [[nodiscard]] std::size_t size() const { return nodes_.size(); }
    [[nodiscard]] std::size_t letters_in(std::uint32_t word) const {
        return word == root ? 0 : std::size_t{nodes_[word].before} + 1;
    }
    /// The letters from the camera on.
    [[nodiscard]] std::vector<Letter> letters(std::uint32_t word) const;
    [[nodiscard]] std::size_t memory_bytes() const {
        return nodes_.capacity() * sizeof(Node) + sizeof(Slot) * slots_.size();
    }

  private:
    struct Slot {
        std::uint32_t parent = root, word = root;  // word == root: the slot is free, because the root is never a child
        Letter letter = 0;
    };
    void grow();
    [[nodiscard]] std::size_t slot_of(std::uint32_t parent, Letter letter) const;
    std::vector<Node> nodes_;
    std::vector<Slot> slots_;  // open addressing, a power of two
};

}  // namespace raylex::display
