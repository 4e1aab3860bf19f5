#include "lpe/algebra/graphs/graph_layout.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace raylex::lpe {

namespace {

constexpr double state_size = 22, gap_y = 14, margin = 24;
constexpr std::size_t longest_line = 30;                                  // characters of a label's line
constexpr double narrowest_gap = 34, widest_gap = 120, gap_per_edge = 2;  // between layers, where edges go up and down
constexpr int ordering_sweeps = 24, placing_sweeps = 40;

/// Whether '-' or '&' stands in the item outside labels.
bool has_operator(const std::string& item) {
    bool quoted = false;
    for (std::size_t i = 0; i < item.size(); ++i) {
        quoted = quoted != (item[i] == '\'' && (i == 0 || item[i - 1] != '\\'));
        if (!quoted && (item[i] == '-' || item[i] == '&')) { return true; }
    }
    return false;
}

/// A state, or a point of an edge.
struct Vertex {
    std::size_t layer = 0;
    double width = 0, height = 0, above = 0;  // `above`: more room at the top
    double y = 0;
    std::vector<std::size_t> left, right;  // neighbours in the layers beside
};

class Layout {
  public:
    explicit Layout(const Graph& graph) : graph_(graph) {}

    GraphLayout run() {
        add_states();
        for (std::size_t k = 0; k < graph_.edges.size(); ++k) { add_edge(k); }
        order();
        place();
        return finish();
    }

  private:
    // ---- layers ---------------------------------------------------------------------------------------------------

    /// States stand in even layers by their distance from the start; those that nothing leaves, behind all that lead
    /// there.
    std::vector<std::size_t> state_layers() const {
        std::vector<std::size_t> layer(graph_.states.size(), 0);
        std::vector<bool> seen(graph_.states.size(), false);
        std::vector<bool> leaves(graph_.states.size(), false);
        std::vector<std::vector<std::size_t>> next(graph_.states.size());
        for (const GraphEdge& edge : graph_.edges) {
            next[edge.from].push_back(edge.to);
            leaves[edge.from] = true;
        }
        std::vector<std::size_t> queue;
        if (!layer.empty()) {
            queue.push_back(0);
            seen[0] = true;
        }
        for (std::size_t i = 0; i < queue.size(); ++i) {
            for (const std::size_t to : next[queue[i]]) {
                if (!seen[to]) {
                    seen[to] = true;
                    layer[to] = layer[queue[i]] + 2;
                    queue.push_back(to);
                }
            }
        }
        for (const GraphEdge& edge : graph_.edges) {
            if (!leaves[edge.to]) { layer[edge.to] = std::max(layer[edge.to], layer[edge.from] + 2); }
        }
        return layer;
    }

    void add_states() {
        const std::vector<std::size_t> layer = state_layers();
        for (std::size_t k = 0; k < graph_.states.size(); ++k) {
            Vertex vertex;
            vertex.layer = layer[k];
            vertex.width = vertex.height = state_size;
            const std::vector<std::string> names = accepted_names(graph_, k);
            for (const std::string& name : names) {
                vertex.width = std::max(vertex.width, static_cast<double>(characters(name)) * letter_width + 30);
            }
            vertex.height = std::max(vertex.height, static_cast<double>(names.size()) * line_height + 12);
            add(std::move(vertex));
        }
        layout_.loop_heights.assign(graph_.states.size(), 0);
    }

    std::size_t add(Vertex vertex) {
        const std::size_t index = vertices_.size();
        layers_.resize(std::max(layers_.size(), vertex.layer + 1));
        layers_[vertex.layer].push_back(index);
        vertices_.push_back(std::move(vertex));
        return index;
    }

    void connect(std::size_t left, std::size_t right) {
        vertices_[left].right.push_back(right);
        vertices_[right].left.push_back(left);
    }

    /// One item of the language where it fits in a line, else a line for every few items of it.
    static std::vector<std::string> lines_of(const GraphEdge& edge) {
        std::vector<std::string> items;
        std::string whole;
        for (const std::string& item : edge.items) {
            items.push_back(has_operator(item) ? "(" + item + ")" : item);
            whole += items.back();
        }
        if (items.size() == 1 || characters(whole) + 2 <= longest_line) {
            return {items.size() == 1 ? whole : "[" + whole + "]"};
        }
        std::vector<std::string> lines{""};
        for (const std::string& item : items) {
            if (!lines.back().empty() && characters(lines.back()) + characters(item) + 1 > longest_line) {
                lines.emplace_back();
            }
            lines.back() += (lines.back().empty() ? "" : " ") + item;
        }
        return lines;
    }

    static double width_of(const std::vector<std::string>& lines) {
        std::size_t longest = 0;
        for (const std::string& line : lines) { longest = std::max(longest, characters(line)); }
        return static_cast<double>(longest) * letter_width + 8;
    }

    void add_edge(std::size_t k) {
        const GraphEdge& edge = graph_.edges[k];
        DrawnEdge drawn;
        drawn.edge = k;
        drawn.lines = lines_of(edge);
        const double width = drawn.label_width = width_of(drawn.lines);
        const double height = drawn.label_height = static_cast<double>(drawn.lines.size()) * line_height + 4;
        if (edge.from == edge.to) {
            drawn.loop = true;
            Vertex& state = vertices_[edge.from];
            state.above = height + 24;
            layout_.loop_heights[edge.from] = state.above;
            state.width = std::max(state.width, width);  // room for the label; the circle keeps its size
            layout_.edges.push_back(std::move(drawn));
            routes_.emplace_back();
            return;
        }
        const std::size_t from = vertices_[edge.from].layer;
        const std::size_t to = vertices_[edge.to].layer;
        const bool forward = to > from;
        // Layers the edge runs through, from left to right; within one layer it goes round through the next.
        const std::size_t first = std::min(from, to) + 1;
        const std::size_t last = from == to ? first : std::max(from, to) - 1;
        const std::size_t labelled = forward || from == to ? first : last;
        drawn.turns = from == to;
        std::vector<std::size_t> route;
        for (std::size_t layer = first; layer <= last; ++layer) {
            Vertex point;
            point.layer = layer;
            point.height = layer == labelled ? height : 4;
            point.width = layer == labelled ? width : 0;
            route.push_back(add(std::move(point)));
            if (route.size() > 1) { connect(route[route.size() - 2], route.back()); }
        }
        connect(forward ? edge.from : edge.to, route.front());
        if (from == to) {
            connect(edge.from, route.front());
        } else {
            connect(route.back(), forward ? edge.to : edge.from);
        }
        if (!forward && from != to) { std::reverse(route.begin(), route.end()); }
        routes_.push_back(std::move(route));
        layout_.edges.push_back(std::move(drawn));
    }

    // ---- order within layers --------------------------------------------------------------------------------------

    [[nodiscard]] std::vector<std::size_t> positions() const {
        std::vector<std::size_t> position(vertices_.size());
        for (const std::vector<std::size_t>& layer : layers_) {
            for (std::size_t i = 0; i < layer.size(); ++i) { position[layer[i]] = i; }
        }
        return position;
    }

    [[nodiscard]] std::size_t crossings() const {
        const std::vector<std::size_t> position = positions();
        std::size_t count = 0;
        for (const std::vector<std::size_t>& layer : layers_) {
            std::vector<std::pair<std::size_t, std::size_t>> links;
            for (const std::size_t v : layer) {
                for (const std::size_t w : vertices_[v].right) { links.emplace_back(position[v], position[w]); }
            }
            for (std::size_t a = 0; a < links.size(); ++a) {
                for (std::size_t b = a + 1; b < links.size(); ++b) {
                    const bool crossed = (links[a].first < links[b].first && links[a].second > links[b].second) ||
                                         (links[a].first > links[b].first && links[a].second < links[b].second);
                    count += crossed ? 1 : 0;
                }
            }
        }
        return count;
    }

    /// Barycentre sweeps, there and back; the order with the fewest crossings is kept.
    void order() {
        std::vector<std::vector<std::size_t>> best = layers_;
        std::size_t fewest = crossings();
        for (int sweep = 0; sweep < ordering_sweeps && fewest > 0; ++sweep) {
            const bool rightwards = sweep % 2 == 0;
            for (std::size_t i = 0; i < layers_.size(); ++i) {
                const std::vector<std::size_t> position = positions();
                std::vector<std::size_t>& layer = layers_[rightwards ? i : layers_.size() - 1 - i];
                std::vector<std::pair<double, std::size_t>> keys;
                for (const std::size_t v : layer) {
                    const std::vector<std::size_t>& beside = rightwards ? vertices_[v].left : vertices_[v].right;
                    double sum = 0;
                    for (const std::size_t w : beside) { sum += static_cast<double>(position[w]); }
                    keys.emplace_back(
                        beside.empty() ? static_cast<double>(position[v]) : sum / static_cast<double>(beside.size()),
                        v);
                }
                std::stable_sort(keys.begin(), keys.end(),
                                 [](const auto& a, const auto& b) { return a.first < b.first; });
                std::transform(keys.begin(), keys.end(), layer.begin(), [](const auto& key) { return key.second; });
            }
            const std::size_t now = crossings();
            if (now < fewest) {
                fewest = now;
                best = layers_;
            }
        }
        layers_ = std::move(best);
    }

    // ---- coordinates ----------------------------------------------------------------------------------------------

    [[nodiscard]] double separation(std::size_t upper, std::size_t lower) const {
        return vertices_[upper].height / 2 + gap_y + vertices_[lower].above + vertices_[lower].height / 2;
    }

    /// The places nearest to those wished for, in order and far enough apart: isotonic regression by pooling.
    void settle(const std::vector<std::size_t>& layer, const std::vector<double>& wished) {
        struct Pool {
            double sum = 0;
            std::size_t count = 0;
            [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
        };
        std::vector<Pool> pools;
        std::vector<double> offset(layer.size(), 0);
        for (std::size_t i = 0; i < layer.size(); ++i) {
            offset[i] = i == 0 ? 0 : offset[i - 1] + separation(layer[i - 1], layer[i]);
            pools.push_back({wished[i] - offset[i], 1});
            while (pools.size() > 1 && pools[pools.size() - 2].mean() > pools.back().mean()) {
                const Pool last = pools.back();
                pools.pop_back();
                pools.back().sum += last.sum;
                pools.back().count += last.count;
            }
        }
        std::size_t i = 0;
        for (const Pool& pool : pools) {
            for (std::size_t n = 0; n < pool.count; ++n, ++i) { vertices_[layer[i]].y = pool.mean() + offset[i]; }
        }
    }

    void place() {
        for (const std::vector<std::size_t>& layer : layers_) { settle(layer, std::vector<double>(layer.size(), 0)); }
        for (int sweep = 0; sweep < placing_sweeps; ++sweep) {
            for (std::size_t i = 0; i < layers_.size(); ++i) {
                const std::vector<std::size_t>& layer = layers_[sweep % 2 == 0 ? i : layers_.size() - 1 - i];
                std::vector<double> wished;
                for (const std::size_t v : layer) {
                    double sum = 0;
                    std::size_t count = 0;
                    for (const std::vector<std::size_t>* beside : {&vertices_[v].left, &vertices_[v].right}) {
                        for (const std::size_t w : *beside) {
                            sum += vertices_[w].y;
                            ++count;
                        }
                    }
                    wished.push_back(count == 0 ? vertices_[v].y : sum / static_cast<double>(count));
                }
                settle(layer, wished);
            }
        }
    }

    GraphLayout finish() {
        double top = 0;
        double bottom = 0;
        for (const Vertex& vertex : vertices_) {
            top = std::min(top, vertex.y - vertex.height / 2 - vertex.above);
            bottom = std::max(bottom, vertex.y + vertex.height / 2);
        }
        std::vector<double> middle;
        std::vector<double> widths;
        double x = margin + 30;  // the arrow to the start
        for (const std::vector<std::size_t>& layer : layers_) {
            double width = 0;
            std::size_t edges = 0;
            for (const std::size_t v : layer) {
                width = std::max(width, vertices_[v].width);
                edges += vertices_[v].right.size();
            }
            middle.push_back(x + width / 2);
            widths.push_back(width);
            x += width + std::clamp(gap_per_edge * static_cast<double>(edges), narrowest_gap, widest_gap);
        }
        const auto box = [&](std::size_t v) {
            const Vertex& vertex = vertices_[v];
            return Box{middle[vertex.layer], vertex.y - top + margin, vertex.width, vertex.height};
        };
        for (std::size_t k = 0; k < graph_.states.size(); ++k) {
            layout_.states.push_back(box(k));
            if (graph_.states[k].accepts.empty()) { layout_.states.back().width = state_size; }
        }
        for (std::size_t k = 0; k < routes_.size(); ++k) {
            for (const std::size_t v : routes_[k]) {
                layout_.edges[k].points.push_back(box(v));
                layout_.edges[k].points.back().width = widths[vertices_[v].layer];
            }
        }
        layout_.width = (middle.empty() ? 0 : middle.back() + widths.back() / 2) + margin;
        layout_.height = bottom - top + 2 * margin;
        return std::move(layout_);
    }

    const Graph& graph_;
    std::vector<Vertex> vertices_;
    std::vector<std::vector<std::size_t>> layers_, routes_;
    GraphLayout layout_;
};

}  // namespace

std::size_t characters(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(
        text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::vector<std::string> accepted_names(const Graph& graph, std::size_t state) {
    std::vector<std::string> names;
    for (const std::size_t channel : graph.states[state].accepts) {
        std::string name = graph.channels[channel];
        constexpr std::size_t longest = 40;
        if (name.size() > longest) {
            std::size_t end = longest;
            while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) { --end; }
            name = name.substr(0, end) + "...";
        }
        names.push_back(std::move(name));
    }
    return names;
}

GraphLayout layout_of(const Graph& graph) {
    return Layout(graph).run();
}

}  // namespace raylex::lpe
