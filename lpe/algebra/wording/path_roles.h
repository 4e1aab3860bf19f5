// Which part of a path each event of an expression can be. Words of W are camera, scattering, terminal in this order,
// so a
// '.' after the camera is no camera, and the one at the end is a terminal. Only the order is looked at, not labels.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "lpe/algebra/wording/event_space.h"
#include "lpe/language/ast.h"

namespace raylex::lpe {

/// How far a path has come, as a set of bits.
enum Progress : std::uint8_t { before_camera = 1, under_way = 2, ended = 4 };
using ProgressSet = std::uint8_t;

class PathRoles {
  public:
    explicit PathRoles(const Node& root);

    /// Whether some order of events is a path at all. If not, every event can be whatever it is.
    [[nodiscard]] bool possible() const { return possible_; }
    [[nodiscard]] bool can_be(const Node& event, EventRole role) const;
    /// How far a path may have come when it leaves the node on its way to the end of a word.
    [[nodiscard]] ProgressSet after(const Node& node) const;
    /// Whether a path that went through the node has always come to its end.
    [[nodiscard]] bool always_ends(const Node& node) const { return after(node) == ended; }

  private:
    struct Range {
        ProgressSet in = 0, out = 0;  // that lie on some way from the start to the end
    };
    /// What was found about a node, for each of the eight sets: repetitions inside one another ask again and again.
    struct Known {
        std::array<std::optional<ProgressSet>, 8> forward, backward;
        ProgressSet reached = 0;
        Range range;
    };
    ProgressSet forward(const Node& node, ProgressSet in);
    ProgressSet backward(const Node& node, ProgressSet out);
    ProgressSet forward_once(const Node& node, ProgressSet in);
    ProgressSet backward_once(const Node& node, ProgressSet out);

    std::unordered_map<const Node*, Known> known_;
    bool possible_ = false;
};

}  // namespace raylex::lpe
