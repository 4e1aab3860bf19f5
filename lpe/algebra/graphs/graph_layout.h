// Where the states and labels of a drawn automaton stand: a layered layout (Sugiyama, Tagawa, Toda 1981), left to
// right. Edges run through points of their own, one in every layer they cross; the first of these carries the label, so
// labels are placed like states and lie on nothing.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lpe/algebra/graphs/graph.h"

namespace raylex::lpe {

struct Box {
    double x = 0, y = 0;  ///< of the middle
    double width = 0, height = 0;
};

struct DrawnEdge {
    std::size_t edge = 0;  ///< index into Graph::edges
    /// Between its ends, in its own direction; each as wide as its layer, so that an edge runs level past what stands
    /// there.
    std::vector<Box> points;
    std::vector<std::string> lines;  ///< of the label, which stands on the first point
    double label_width = 0, label_height = 0;
    bool loop = false;   ///< from a state to itself: no points, drawn above it
    bool turns = false;  ///< between states of one layer: it turns round at its label
};

struct GraphLayout {
    std::vector<Box> states;
    std::vector<double> loop_heights;  ///< room above each state for its loop, 0 without one
    std::vector<DrawnEdge> edges;
    double width = 0, height = 0;
};

/// Sizes of text in the drawing.
inline constexpr double letter_width = 7.3, line_height = 15;

[[nodiscard]] GraphLayout layout_of(const Graph& graph);

/// The names of the channels that the state accepts, one a line.
[[nodiscard]] std::vector<std::string> accepted_names(const Graph& graph, std::size_t state);

/// Characters of a UTF-8 text.
[[nodiscard]] std::size_t characters(const std::string& text);

}  // namespace raylex::lpe
