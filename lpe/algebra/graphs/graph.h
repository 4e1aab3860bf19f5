// The minimal automaton of some channels as a graph to look at. Its states are what matters about the beginning of a
// path; its edges are events.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct GraphState {
    std::vector<std::size_t> accepts;  ///< channels that match a path that ends here
    std::string reached_by;            ///< a shortest path to the state, as a sentence: "camera, diffuse reflection"
};

struct GraphEdge {
    std::size_t from = 0, to = 0;
    std::vector<std::string> items;  ///< the events of the edge, in the notation of expressions; never empty
};

/// State 0 is the start. The dead state and the edges to it are left out. Channels are cut to W (lpe/README.md).
struct Graph {
    std::vector<std::string> channels;  ///< the name of each channel, or its expression if it has no name
    std::vector<GraphState> states;
    std::vector<GraphEdge> edges;  ///< at most one between two states
    std::vector<std::string> warnings;
};

/// Only labels that the expressions name are told apart; the alphabet of `words` is ignored. Errors: an expression that
/// does not parse, more than 32 channels, or more states than limits::graph_states.
Result<Graph> graph_of(std::span<const ChannelSource> channels, const PathStrings& words = {});

/// The graph in the DOT language, from which Graphviz makes drawings.
[[nodiscard]] std::string to_dot(const Graph& graph);

}  // namespace raylex::lpe
