#include "experiments/stability/suite/suite_chart.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "experiments/report/html.h"

namespace raylex::experiments {
namespace {

constexpr double left = 250, width = 900, row_height = 17, top = 8, bottom = 34;
constexpr double least = -4, most = 1;  // powers of ten

double x_of(double share) {
    const double power = share > 0 ? std::log10(share) : least;
    return left +
           (width - left - 16) * (std::clamp(std::isnan(power) ? most : power, least, most) - least) / (most - least);
}

std::string rounded(double value) {
    return std::to_string(static_cast<long>(std::lround(value)));
}

/// Returns the fraction of its tolerance that a line used; for an exact line 0, or a value above any.
double share_of(const LineResult& line) {
    if (line.result == LineState::died || std::isnan(line.error)) return INFINITY;
    if (line.allowed > 0) return line.error / line.allowed;
    return line.error > 0 ? INFINITY : 0;
}

std::string dots(std::span<const LineResult> lines, const std::string& name, double y, bool hollow) {
    std::string svg;
    for (const LineResult& line : lines) {
        if (line.name != name || line.result == LineState::not_applicable) continue;
        const std::string color = line.result == LineState::holds ? "var(--good)" : "var(--bad)";
        svg += "<circle cx=\"" + rounded(x_of(share_of(line))) + "\" cy=\"" + rounded(y) + "\" r=\"" +
               (hollow ? "5" : "3.5") + "\" fill=\"" + (hollow ? "none" : color) +
               "\" fill-opacity=\"0.55\" stroke=\"" + color + "\"><title>" +
               escape_html(line.setting + ": " + line.error_text()) + "</title></circle>";
    }
    return svg;
}

}  // namespace

std::string suite_chart(std::span<const LineResult> lines, std::span<const LineResult> baseline) {
    std::vector<std::string> names;
    for (const LineResult& line : lines)
        if (line.result != LineState::not_applicable && std::find(names.begin(), names.end(), line.name) == names.end())
            names.push_back(line.name);
    const double end = top + row_height * double(names.size()), height = end + bottom;
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + rounded(width) + " " +
                      rounded(height) + "\" font-size=\"12\" fill=\"currentColor\" role=\"img\">";
    for (int power = static_cast<int>(least); power <= static_cast<int>(most); ++power) {
        const std::string x = rounded(x_of(std::pow(10, power)));
        const char* const labels[] = {"0.0001 and less", "0.001", "0.01", "0.1", "the tolerance", "10 and more"};
        svg += "<path d=\"M" + x + "," + rounded(top) + "V" + rounded(end) + "\" stroke=\"" +
               (power == 0 ? "var(--bad)" : "var(--line)") + "\"/><text x=\"" + x + "\" y=\"" + rounded(end + 16) +
               "\" text-anchor=\"" + (power == static_cast<int>(most) ? "end" : "middle") + "\">" +
               labels[power - static_cast<int>(least)] + "</text>";
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        const double y = top + row_height * (double(i) + 0.5);
        svg += "<text x=\"0\" y=\"" + rounded(y + 4) + "\">" + escape_html(names[i]) + "</text>" +
               dots(lines, names[i], y, false) + dots(baseline, names[i], y, true);
    }
    return svg + "</svg>";
}

}  // namespace raylex::experiments
