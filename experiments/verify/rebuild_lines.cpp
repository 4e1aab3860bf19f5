#include "experiments/verify/rebuild_lines.h"

#include "experiments/program/console.h"

namespace raylex::experiments {

std::vector<std::string> rebuild_lines(const display::SplitResult& result) {
    const display::Rebuild& rebuild = result.rebuild;
    std::vector<std::string> lines;
    const auto share = [&](double light) {
        return rebuild.whole > 0 ? number_text(100 * light / rebuild.whole) + " % of '" + result.of + "'"
                                 : number_text(light);
    };
    const auto pixel = [](const auto& at) {
        return " at pixel (" + std::to_string(at.x) + ", " + std::to_string(at.y) + ")";
    };
    const auto add = [&](const std::string& what, const display::LightDifference& difference, const char* cause) {
        if (difference.pixels == 0) return;
        lines.push_back(what + ": " + share(difference.light) + " in " + counted(difference.pixels, "pixel") +
                        ", at most " + number_text(difference.largest) + pixel(difference));
        if (const std::string layer = difference.cause(); !layer.empty())
            lines.back() += "; it equals the layer '" + layer + "', which the sum " + cause;
    };
    add("unassigned light (" + result.of + " minus sum)", rebuild.unassigned, "lacks");
    for (const auto& [factor, light] : rebuild.lost)
        if (light > 0) lines.push_back("unassigned where '" + factor + "' is 0: " + share(light));
    add("light counted twice (sum minus " + result.of + ")", rebuild.doubled, "has once too often");
    for (const auto& [layer, negative] : rebuild.negative)
        lines.push_back("negative values in '" + layer + "': " + counted(negative.pixels, "pixel") + ", the lowest " +
                        number_text(static_cast<double>(negative.lowest)) + pixel(negative));
    return lines;
}

}  // namespace raylex::experiments
