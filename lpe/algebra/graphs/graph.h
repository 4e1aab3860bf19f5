// The minimal automaton of some channels as a graph to look at: what a path's state is, and what leads from one to
// another.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

struct GraphState {
    std::vector<std::size_t> accepts;  ///< channels whose paths may end here
    std::string reached_by;            ///< a shortest path to it in words: "camera, diffuse reflection"
};

struct GraphEdge {
    std::size_t from = 0, to = 0;
    std::vector<std::string> items;  ///< the events that lead there, in the notation of expressions; never empty
};

/// State 0 is the start; the dead state and what leads to it are left out. Channels are cut to W.
struct Graph {
    std::vector<std::string> channels;  ///< names, or expressions where there is none
    std::vector<GraphState> states;
    std::vector<GraphEdge> edges;  ///< at most one between two states
    std::vector<std::string> warnings;
};

/// Labels are those that the expressions name, whatever an alphabet in `words` says. Errors: an expression that does
/// not parse, more than 32 channels, or more states than limits::graph_states.
Result<Graph> graph_of(std::span<const ChannelSource> channels, const Words& words = {});

/// In Graphviz' DOT language.
[[nodiscard]] std::string to_dot(const Graph& graph);

/// As SVG, laid out here: left to right, one column for each number of events from the start.
[[nodiscard]] std::string to_svg(const Graph& graph);

}  // namespace raylex::lpe
