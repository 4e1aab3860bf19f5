// Finds the layer that a name without the application's prefix denotes.
#include <algorithm>
#include <cctype>

#include "display/output/reader/exr_layers.h"
#include "display/output/splits/split_check.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

// The prefix of a name: "ViewLayer." of "ViewLayer.Combined"; empty without a dot.
std::string_view prefix_of(std::string_view name) {
    return name.substr(0, name.rfind('.') + 1);
}

// The names without prefix under which a layer is found; a name can occur twice.
std::vector<std::string_view> short_names(std::string_view name, std::string_view shared) {
    std::vector<std::string_view> names;
    for (std::size_t dot = name.find('.'); dot != std::string_view::npos; dot = name.find('.', dot + 1))
        if (dot + 1 < name.size()) names.push_back(name.substr(dot + 1));
    if (!shared.empty() && name.size() > shared.size()) names.push_back(name.substr(shared.size()));
    return names;
}

std::vector<const ImageLayer*> called(const ExrImage& image, std::string_view name) {
    std::vector<const ImageLayer*> found;
    const std::string_view shared = shared_prefix(image);
    for (const ImageLayer& layer : image.layers) {
        const std::vector<std::string_view> names = short_names(layer.name, shared);
        if (std::find(names.begin(), names.end(), name) != names.end()) found.push_back(&layer);
    }
    return found;
}

// A hint with the closest name, or else with the names that contain the word or are contained in it.
std::string likely_layer(const ExrImage& image, std::string_view name) {
    const std::vector<std::string> known = spoken_names(image);
    for (const std::string& each : known)
        if (lower_case(each) == lower_case(name)) return "did you mean '" + each + "'?";
    if (std::string near = near_miss(name, known); !near.empty()) return near;
    std::vector<std::string> alike;
    for (const ImageLayer& layer : image.layers)
        if (name.size() >= 3 &&
            (lower_case(layer.name).find(lower_case(name)) != std::string::npos ||
             (layer.name.size() >= 3 && lower_case(name).find(lower_case(layer.name)) != std::string::npos)))
            alike.push_back(layer.name);
    return alike.empty() ? std::string() : "names like it: " + list_names(alike);
}

// The layers of the part with that name: one, or the ranks of a cryptomatte, CryptoObject00 and so on.
std::vector<const ImageLayer*> layers_of_part(const ExrImage& image, std::string_view part) {
    std::vector<const ImageLayer*> found;
    for (const ImageLayer& layer : image.layers)
        if (!part.empty() && layer.part == part) found.push_back(&layer);
    const bool ranks = std::all_of(found.begin(), found.end(), [part](const ImageLayer* layer) {
        return layer->name.starts_with(part) &&
               layer->name.find_first_not_of("0123456789", part.size()) == std::string::npos;
    });
    return found.size() == 1 || ranks ? found : std::vector<const ImageLayer*>{};
}

}  // namespace

std::string_view shared_prefix(const ExrImage& image) {
    std::string_view shared;
    bool first = true;
    for (const ImageLayer& layer : image.layers) {
        if (first) shared = layer.name;
        std::size_t same = 0;
        while (same < shared.size() && same < layer.name.size() && shared[same] == layer.name[same]) ++same;
        shared = shared.substr(0, same);
        first = false;
    }
    return image.layers.size() < 2 ? std::string_view() : shared.substr(0, shared.find_last_of("._-") + 1);
}

std::vector<std::string> spoken_names(const ExrImage& image) {
    std::vector<std::string> names = image.layer_names();
    const std::string_view shared = shared_prefix(image);
    for (const ImageLayer& layer : image.layers)
        for (const std::string_view name : short_names(layer.name, shared)) names.emplace_back(name);
    return names;
}

std::string likely_beauty(const ExrImage& image) {
    for (const char* habit : {"beauty", "combined", "rgba", "rgb", "ci", "c", "image", "main"})
        for (const ImageLayer& layer : image.layers)
            if (lower_case(layer.name).substr(prefix_of(layer.name).size()) == habit) return layer.name;
    return {};
}

Result<const ImageLayer*> resolve_layer(const ExrImage& image, std::string_view name, std::string_view beside) {
    if (const ImageLayer* found = image.layer(name)) return found;
    if (name.empty() || name == "beauty")
        if (const std::string likely = likely_beauty(image); !likely.empty()) return image.layer(likely);
    if (const std::string_view prefix = prefix_of(beside); !prefix.empty() && !name.empty())
        if (const ImageLayer* found = image.layer(std::string(prefix) + std::string(name))) return found;
    Error error;
    error.file = image.path;
    const std::vector<const ImageLayer*> found = name.empty() ? std::vector<const ImageLayer*>{} : called(image, name);
    if (found.size() == 1) return found.front();
    if (found.size() > 1) {
        std::vector<std::string> names;
        for (const ImageLayer* layer : found) names.push_back(layer->name);
        error.message = "several layers are called '" + std::string(name) + "'; expected one of: " + list_names(names);
        return error;
    }
    if (const auto part = layers_of_part(image, name); !part.empty()) return part.front();
    error.message = "the image has no layer '" + std::string(name.empty() ? "beauty" : name) +
                    "'; expected one of: " + list_names(image.layer_names());
    error.hint = likely_layer(image, name);
    return error;
}

std::vector<const ImageLayer*> layers_like(const ExrImage& image, std::string_view glob, std::string_view beside) {
    std::vector<const ImageLayer*> found;
    const ImageLayer* beauty = image.layer("beauty");
    for (const ImageLayer& layer : image.layers)
        if (glob_match(glob, &layer == beauty ? "beauty" : layer.name)) found.push_back(&layer);
    for (const std::string_view prefix : {prefix_of(beside), shared_prefix(image)}) {
        if (!found.empty() || prefix.empty()) continue;
        for (const ImageLayer& layer : image.layers)
            if (layer.name.starts_with(prefix) && glob_match(glob, layer.name.substr(prefix.size())))
                found.push_back(&layer);
    }
    return found;
}

}  // namespace raylex::display
