// Finds the role that each event of an expression can have in a path. Words of W are camera, scattering, terminal in
// this order, so a '.' after the camera is no camera, and a '.' at the end is a terminal. The analysis uses the order
// only and ignores labels.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "lpe/algebra/wording/event_space.h"
#include "lpe/language/ast.h"

namespace raylex::lpe {

/// The progress of a path, as a set of bits.
enum Progress : std::uint8_t { before_camera = 1, under_way = 2, ended = 4 };
using ProgressSet = std::uint8_t;

class PathRoles {
  public:
    explicit PathRoles(const Node& root);

    /// Returns whether some order of events forms a path. If not, every event can have every role.
    [[nodiscard]] bool possible() const { return possible_; }
    [[nodiscard]] bool can_be(const Node& event, EventRole role) const;
    /// The possible progress of a path that leaves the node and goes on to the end of a word.
    [[nodiscard]] ProgressSet after(const Node& node) const;
    /// Returns whether every path has ended after the node.
    [[nodiscard]] bool always_ends(const Node& node) const { return after(node) == ended; }

  private:
    struct Range {
        ProgressSet in = 0, out = 0;  // on some way from start to end
    };
    /// Cached results for a node and each of the eight sets; without the cache nested repetitions would repeat the
    /// work.
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
