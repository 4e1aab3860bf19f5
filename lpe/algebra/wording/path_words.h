// Describes expressions in English: as one sentence, and piece by piece.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lpe/algebra/wording/event_words.h"
#include "lpe/algebra/wording/path_roles.h"
#include "lpe/language/ast.h"

namespace raylex::lpe {

/// A piece of an expression and its description.
struct Piece {
    std::size_t begin = 0, end = 0;  ///< its bytes in the text
    int depth = 0;                   ///< nesting depth
    std::string words;
};

class PathTeller {
  public:
    /// `root` is the root of the expression. All arguments must outlive the object.
    PathTeller(const EventTeller& events, const EventTeller::Members& occurring, const Node& root);

    /// "from the camera, one diffuse reflection, ending at a light". A mark replaces the part of the description that
    /// would be too long.
    std::string sentence();
    std::vector<Piece> pieces();

  private:
    enum class StepKind : std::uint8_t { camera, middle, end };
    struct Step {
        StepKind kind = StepKind::middle;
        std::string text;
        std::string straight{};  ///< for an end: the words after "straight to"
    };
    struct Count {
        int min = 1, max = 1;
    };

    std::vector<Step> steps(const Node& node);
    std::vector<Step> event_steps(const Node& node, const std::vector<const Node*>& events, Count count);
    std::vector<Step> repeat_steps(const Node& node);
    std::vector<Step> choice_steps(const Node& node);
    std::vector<Step> language_steps(const Node& node);
    std::string join(const std::vector<Step>& steps, bool inner) const;
    EventPhrase phrase(const std::vector<const Node*>& events, EventRole role);
    void add_pieces(const Node& node, int depth, std::vector<Piece>& pieces);
    bool too_long(const Node& node);

    const EventTeller& events_;
    const EventTeller::Members& occurring_;
    const Node& root_;
    PathRoles roles_;
    int said_ = 0;  // number of nodes described so far
    int depth_ = 0;
    bool after_camera_ = false;
    std::map<std::pair<std::vector<const Node*>, EventRole>, EventPhrase> phrases_;
};

}  // namespace raylex::lpe
