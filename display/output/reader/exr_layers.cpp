#include "display/output/reader/exr_layers.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "display/services/parameters.h"

namespace raylex::display {

namespace {

// The rank of a channel name in a colour: 0..3 for R G B A in any common spelling, 4 and up for other colour channels,
// -1 if it is not one.
int colour_rank(std::string_view plane) {
    static const std::vector<std::pair<std::string, int>> ranks{
        {"r", 0},     {"g", 1}, {"b", 2},  {"a", 3},  {"red", 0}, {"green", 1}, {"blue", 2},
        {"alpha", 3}, {"y", 4}, {"ry", 5}, {"by", 6}, {"ar", 7},  {"ag", 8},    {"ab", 9}};
    const std::string name = lower_case(plane);
    for (const auto& [spelling, rank] : ranks)
        if (spelling == name) return rank;
    return -1;
}

// The three planes with these names, ignoring case; null for a missing one.
std::array<const ImagePlane*, 3> find_three(const std::vector<ImagePlane>& planes,
                                            const std::array<const char*, 3>& names) {
    std::array<const ImagePlane*, 3> found{};
    for (std::size_t i = 0; i < 3; ++i)
        for (const ImagePlane& plane : planes)
            if (found[i] == nullptr && lower_case(plane.name) == names[i]) found[i] = &plane;
    return found;
}

bool all_found(const std::array<const ImagePlane*, 3>& planes) {
    return std::find(planes.begin(), planes.end(), nullptr) == planes.end();
}

bool has_plane(const ImageLayer& layer, const std::string& name) {
    return std::any_of(layer.planes.begin(), layer.planes.end(),
                       [&name](const ImagePlane& plane) { return plane.name == name; });
}

ImageLayer* find_layer(std::vector<ImageLayer>& layers, const std::string& name) {
    for (ImageLayer& layer : layers)
        if (layer.name == name) return &layer;
    return nullptr;
}

// Adds a plane to the layer of that name, or under a different name if the layer already has such a plane.
void add_plane(std::vector<ImageLayer>& layers, const std::string& name, const std::string& part, ImagePlane plane) {
    std::string chosen = name;
    for (int attempt = 1;; ++attempt) {
        ImageLayer* layer = find_layer(layers, chosen);
        if (layer == nullptr) {
            layers.push_back({chosen, part, {}});
            layer = &layers.back();
        }
        if (!has_plane(*layer, plane.name)) {
            layer->planes.push_back(std::move(plane));
            return;
        }
        chosen = attempt == 1 && !part.empty() ? part + (name.empty() ? "" : "." + name)
                                               : (name.empty() ? "layer" : name) + "#" + std::to_string(attempt + 1);
    }
}

bool is_main_name(const std::string& part) {
    const std::string name = lower_case(part);
    return name.empty() || name == "rgba" || name == "rgb" || name == "main" || name == "image";
}

// `main`: the part's nameless colour is the main image of the file.
void add_nameless(std::vector<ImageLayer>& layers, const std::string& part, bool main, std::vector<ImagePlane> planes) {
    const bool positions = all_found(find_three(planes, {"x", "y", "z"}));
    const auto belongs = [positions](const ImagePlane& plane) {
        const std::string name = lower_case(plane.name);
        return colour_rank(name) >= 0 || (positions && (name == "x" || name == "z"));
    };
    const bool nothing_belongs = std::none_of(planes.begin(), planes.end(), belongs);
    const std::string base = (nothing_belongs ? is_main_name(part) : main) ? "" : part;
    for (ImagePlane& plane : planes) {
        std::string name = base;
        if (!belongs(plane) && (base.empty() || !nothing_belongs))
            name = base.empty() ? plane.name : base + "." + plane.name;
        add_plane(layers, name, part, std::move(plane));
    }
}

void order_planes(ImageLayer& layer) {
    std::stable_sort(layer.planes.begin(), layer.planes.end(), [](const ImagePlane& a, const ImagePlane& b) {
        const auto rank = [](const ImagePlane& plane) {
            const int known = colour_rank(plane.name);
            return known >= 0 && known <= 3 ? known : 4;
        };
        return rank(a) < rank(b);
    });
}

}  // namespace

std::vector<ImageLayer> name_layers(std::vector<FilePart> parts) {
    std::vector<ImageLayer> layers;
    const bool one_part = parts.size() == 1;
    bool first = true;
    for (FilePart& part : parts) {
        std::vector<ImagePlane> nameless;
        for (ImagePlane& channel : part.channels) {
            const std::size_t dot = channel.name.rfind('.');
            if (dot == std::string::npos || dot == 0 || dot + 1 == channel.name.size()) {
                nameless.push_back(std::move(channel));
                continue;
            }
            const std::string layer = channel.name.substr(0, dot);
            channel.name.erase(0, dot + 1);
            add_plane(layers, layer, part.name, std::move(channel));
        }
        add_nameless(layers, part.name, one_part || (first && is_main_name(part.name)), std::move(nameless));
        first = false;
    }
    for (ImageLayer& layer : layers) order_planes(layer);
    // The nameless layer comes first, because it is the main image of the file.
    std::stable_partition(layers.begin(), layers.end(), [](const ImageLayer& layer) { return layer.name.empty(); });
    return layers;
}

const ImagePlane* ImageLayer::plane(std::string_view plane_name) const {
    for (const ImagePlane& each : planes)
        if (each.name == plane_name) return &each;
    for (const ImagePlane& each : planes)
        if (lower_case(each.name) == lower_case(plane_name)) return &each;
    return nullptr;
}

bool ImageLayer::is_color() const {
    return all_found(find_three(planes, {"r", "g", "b"})) || all_found(find_three(planes, {"red", "green", "blue"}));
}

std::array<const ImagePlane*, 3> ImageLayer::triple() const {
    for (const std::array<const char*, 3>& names :
         {std::array{"r", "g", "b"}, std::array{"red", "green", "blue"}, std::array{"x", "y", "z"}}) {
        const std::array<const ImagePlane*, 3> found = find_three(planes, names);
        if (all_found(found)) return found;
    }
    const ImagePlane* only = nullptr;
    for (const ImagePlane& each : planes) {
        if (colour_rank(each.name) == 3 && planes.size() > 1) continue;
        if (only != nullptr) return {};
        only = &each;
    }
    return {only, only, only};
}

const ImageLayer* ExrImage::layer(std::string_view name) const {
    for (const ImageLayer& each : layers)
        if (each.name == name) return &each;
    // The nameless image can also be addressed by the names that renderers show for it, and by the name of its part.
    for (const ImageLayer& each : layers)
        if (each.name.empty() &&
            (name == "beauty" || is_main_name(std::string(name)) || lower_case(each.part) == lower_case(name)))
            return &each;
    if (!name.empty()) return nullptr;
    for (const ImageLayer& each : layers)
        if (each.name == "beauty") return &each;
    return nullptr;
}

std::vector<std::string> ExrImage::layer_names() const {
    std::vector<std::string> names;
    for (const ImageLayer& each : layers) names.push_back(each.name);
    return names;
}

Result<const ImageLayer*> ExrImage::require_layer(std::string_view name) const {
    return resolve_layer(*this, name);
}

std::string list_names(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < 40; ++i)
        text += (i == 0 ? "" : ", ") + (names[i].empty() ? std::string("beauty") : names[i]);
    if (names.size() > 40) text += ", ... (" + std::to_string(names.size()) + " in all)";
    return text.empty() ? "(none)" : text;
}

std::string format_partition(const PartitionDeclaration& partition) {
    std::string text = (partition.of.empty() ? "beauty" : partition.of) + " = ";
    for (std::size_t i = 0; i < partition.layers.size(); ++i) text += (i == 0 ? "" : " + ") + partition.layers[i];
    return text;
}

PartitionDeclaration parse_partition(const std::string& name, const std::string& text) {
    PartitionDeclaration partition;
    partition.name = name;
    const std::size_t equals = text.find(" = ");
    if (equals == std::string::npos) return partition;
    partition.of = text.substr(0, equals);
    for (std::size_t begin = equals + 3; begin < text.size();) {
        const std::size_t plus = std::min(text.find(" + ", begin), text.size());
        partition.layers.push_back(text.substr(begin, plus - begin));
        begin = plus + 3;
    }
    return partition;
}

}  // namespace raylex::display
