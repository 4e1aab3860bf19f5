// The drawing itself: layout to SVG.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "lpe/algebra/graphs/graph.h"
#include "lpe/algebra/graphs/graph_layout.h"

namespace raylex::lpe {

namespace {

std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f", value);
    return text.data();
}

std::string point(double x, double y) {
    return number(x) + " " + number(y);
}

/// Text as XML wants it; bytes that are no text become '?'.
std::string xml(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        switch (c) {
            case '&':
                escaped += "&amp;";
                break;
            case '<':
                escaped += "&lt;";
                break;
            case '>':
                escaped += "&gt;";
                break;
            case '"':
                escaped += "&quot;";
                break;
            default:
                escaped += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
        }
    }
    return escaped;
}

std::string text_lines(const std::vector<std::string>& lines, double x, double y, const std::string& style) {
    std::string svg;
    double baseline = y - static_cast<double>(lines.size()) * line_height / 2 + 0.75 * line_height;
    for (const std::string& line : lines) {
        svg += "<text class=\"" + style + "\" x=\"" + number(x) + "\" y=\"" + number(baseline) + "\">" + xml(line) +
               "</text>\n";
        baseline += line_height;
    }
    return svg;
}

/// Where an edge leaves or meets a state: on the side that it comes from.
double side_x(const Box& state, double other_x) {
    return state.x + (other_x >= state.x ? 1 : -1) * state.width / 2;
}

class Curve {
  public:
    Curve(double x, double y) : x_(x), y_(y), path_("M " + point(x, y)) {}
    /// Leaves and arrives level.
    void bend_to(double x, double y) {
        const double middle = (x_ + x) / 2;
        path_ += " C " + point(middle, y_) + " " + point(middle, y) + " " + point(x, y);
        x_ = x;
        y_ = y;
    }
    void line_to(double x) {
        x_ = x;
        path_ += " L " + point(x_, y_);
    }
    [[nodiscard]] const std::string& path() const { return path_; }

  private:
    double x_, y_;
    std::string path_;
};

/// A smooth way through the points: up and down between the layers, level within them.
std::string curve(const Box& from, const DrawnEdge& edge, const Box& to) {
    const Box& first = edge.points.front();
    const double way = first.x >= from.x ? 1 : -1;
    Curve curve(side_x(from, first.x), from.y);
    if (edge.turns) {
        const double near = first.x - first.width / 2;
        curve.bend_to(near, first.y - 4);
        curve.line_to(first.x);
        Curve back(first.x, first.y + 4);
        back.line_to(near);
        back.bend_to(side_x(to, first.x), to.y);
        return curve.path() + " " + back.path();
    }
    for (const Box& next : edge.points) {
        curve.bend_to(next.x - way * next.width / 2, next.y);
        curve.line_to(next.x + way * next.width / 2);
    }
    curve.bend_to(side_x(to, edge.points.back().x), to.y);
    return curve.path();
}

std::string loop(const Box& state, double room) {
    const double top = state.y - state.height / 2;
    const double reach = std::min(room, 28.0);
    return "M " + point(state.x - 5, top) + " C " + point(state.x - 22, top - reach) + " " +
           point(state.x + 22, top - reach) + " " + point(state.x + 5, top);
}

std::string edge_svg(const Graph& graph, const GraphLayout& layout, const DrawnEdge& drawn) {
    const GraphEdge& edge = graph.edges[drawn.edge];
    const Box& from = layout.states[edge.from];
    std::string label;
    std::string path;
    if (drawn.loop) {
        path = loop(from, layout.loop_heights[edge.from]);
        const double lines = static_cast<double>(drawn.lines.size());
        label = text_lines(drawn.lines, from.x, from.y - from.height / 2 - 24 - lines * line_height / 2, "event");
    } else {
        path = curve(from, drawn, layout.states[edge.to]);
        const Box& at = drawn.points.front();
        label = "<rect class=\"clear\" x=\"" + number(at.x - drawn.label_width / 2) + "\" y=\"" +
                number(at.y - drawn.label_height / 2) + "\" width=\"" + number(drawn.label_width) + "\" height=\"" +
                number(drawn.label_height) + "\"/>\n" + text_lines(drawn.lines, at.x, at.y, "event");
    }
    return "<path class=\"edge\" d=\"" + path + "\"/>\n" + label;
}

std::string state_svg(const Graph& graph, const GraphLayout& layout, std::size_t k) {
    const Box& box = layout.states[k];
    std::string svg = "<g><title>" + xml(k == 0 ? "start" : graph.states[k].reached_by) + "</title>\n";
    const std::vector<std::string> names = accepted_names(graph, k);
    if (names.empty()) {
        svg += "<circle class=\"state\" cx=\"" + number(box.x) + "\" cy=\"" + number(box.y) + "\" r=\"" +
               number(box.height / 2) + "\"/>\n";
    } else {
        for (const double inset : {0.0, 3.0}) {
            svg += "<rect class=\"accepting\" x=\"" + number(box.x - box.width / 2 + inset) + "\" y=\"" +
                   number(box.y - box.height / 2 + inset) + "\" width=\"" + number(box.width - 2 * inset) +
                   "\" height=\"" + number(box.height - 2 * inset) + "\" rx=\"8\"/>\n";
        }
        svg += text_lines(names, box.x, box.y, "name");
    }
    return svg + "</g>\n";
}

}  // namespace

std::string to_svg(const Graph& graph) {
    const GraphLayout layout = layout_of(graph);
    const double width = std::max(layout.width, 240.0);
    const double height = std::max(layout.height, 60.0);
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(width) + "\" height=\"" +
                      number(height) + "\" viewBox=\"0 0 " + number(width) + " " + number(height) + "\">\n";
    svg +=
        "<style>\n"
        ".edge { fill: none; stroke: #45525e; stroke-width: 1.3; marker-end: url(#arrow); }\n"
        ".state { fill: #e8edf2; stroke: #45525e; stroke-width: 1.3; }\n"
        ".accepting { fill: #dff0df; stroke: #2f6b36; stroke-width: 1.3; }\n"
        ".clear { fill: white; }\n"
        "text { text-anchor: middle; }\n"
        ".event { font: 12px 'DejaVu Sans Mono', monospace; fill: #12324f; }\n"
        ".name { font: bold 12px 'DejaVu Sans', sans-serif; fill: #1d4422; }\n"
        "</style>\n"
        "<defs><marker id=\"arrow\" viewBox=\"0 0 10 10\" refX=\"9\" refY=\"5\" markerWidth=\"7\" markerHeight=\"7\" "
        "orient=\"auto-start-reverse\"><path d=\"M 0 1 L 9 5 L 0 9 z\" fill=\"#45525e\"/></marker></defs>\n"
        "<rect class=\"clear\" width=\"100%\" height=\"100%\"/>\n";
    if (graph.states.empty()) {
        return svg + text_lines({"no path is accepted"}, width / 2, height / 2, "name") + "</svg>\n";
    }
    const Box& start = layout.states.front();
    svg += "<path class=\"edge\" d=\"M " + point(start.x - start.width / 2 - 28, start.y) + " L " +
           point(start.x - start.width / 2, start.y) + "\"/>\n";
    for (const DrawnEdge& edge : layout.edges) { svg += edge_svg(graph, layout, edge); }
    for (std::size_t k = 0; k < graph.states.size(); ++k) { svg += state_svg(graph, layout, k); }
    return svg + "</svg>\n";
}

}  // namespace raylex::lpe
