#include "experiments/report/guide/guide_view.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/report/html.h"
#include "experiments/report/pixel_data.h"

namespace raylex::experiments {
namespace {

constexpr std::uint32_t map_depth = 5, map_side = 1u << map_depth;
constexpr std::size_t most_maps = 4096;

unsigned char byte_of(transport::Real share) {
    if (!(share > 0)) return 0;
    const double steps = 128 + 10 * std::log2(double{share} * map_side * map_side);
    return static_cast<unsigned char>(std::clamp(std::round(steps), 1.0, 255.0));
}

}  // namespace

Json guide_view_json(const transport::GuideView& view) {
    std::map<std::uint32_t, std::size_t> counts;
    for (const std::uint32_t region : view.regions)
        if (region != transport::GuideView::no_region) ++counts[region];
    std::vector<std::uint32_t> order;
    for (const auto& [region, count] : counts) order.push_back(region);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return counts[a] > counts[b]; });
    std::map<std::uint32_t, std::size_t> numbers{{transport::GuideView::no_region, 0}};
    std::vector<unsigned char> maps;
    Json probabilities = Json::array();
    for (const std::uint32_t number : order) {
        const transport::GuideTree::Region& region = view.tree.regions()[number];
        numbers.emplace(number, numbers.size());
        probabilities.push_back(std::round(1e4 * double{region.share}) / 1e4);
        if (numbers.size() > most_maps + 1) continue;
        for (const transport::Real share : view.tree.shares_of_cells(region, map_depth)) maps.push_back(byte_of(share));
    }
    std::vector<float> points;
    for (const std::uint32_t region : view.regions) points.push_back(static_cast<float>(numbers.at(region)));
    return {{"step", view.step},
            {"width", view.width},
            {"height", view.height},
            {"side", map_side},
            {"camera", view.to_camera},
            {"probabilities", probabilities},
            {"points", pack_integers(points)},
            {"maps", pack_bytes(maps)}};
}

std::string guide_view_html(const std::string& record, int width, int height) {
    try {
        const Json view = parse_json(record).at("guide").at("view");
        const std::int32_t step = whole(view.at("step"));
        const auto points = [&](std::int64_t pixels) { return (pixels + step - 1) / step; };
        if (step < 1 || view.at("width") != points(width) || view.at("height") != points(height)) return {};
        return "<script type=\"application/json\" class=\"guide\">" + script_json(json_text(view)) + "</script>\n";
    } catch (const Json::exception&) { return {}; }
}

}  // namespace raylex::experiments
