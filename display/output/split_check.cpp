#include "display/output/split_check.h"

#include <algorithm>

#include "display/output/exr_layers.h"
#include "display/output/split_sum.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

Error split_error(const ExrImage& image, const std::string& message) {
    Error error;
    error.file = image.path;
    error.message = message;
    return error;
}

// A layer's three components, or why it cannot take part in a sum of light.
Result<std::array<const ImagePlane*, 3>> summable(const ExrImage& image, const ImageLayer& layer) {
    const std::string name = layer.name.empty() ? "beauty" : layer.name;
    const std::array<const ImagePlane*, 3> planes = layer.triple();
    if (planes[0] == nullptr) {
        std::vector<std::string> names;
        for (const ImagePlane& plane : layer.planes) names.push_back(plane.name);
        return split_error(image, "layer '" + name + "' has the channels " + list_names(names) +
                                      "; expected R G B, X Y Z or a single one");
    }
    for (const ImagePlane* plane : planes)
        if (plane->stored == StoredType::unsigned_int)
            return split_error(image, "layer '" + name + "' holds unsigned integers (" + plane->name +
                                          "); expected light, stored as half or float");
    return planes;
}

SplitLayer split_layer(const std::array<const ImagePlane*, 3>& planes) {
    SplitLayer layer;
    for (std::size_t c = 0; c < 3; ++c) {
        layer.planes[c] = planes[c]->values;
        layer.types[c] = planes[c]->stored;
    }
    return layer;
}

bool has_wildcard(const std::string& glob) {
    return glob.find_first_of("*?") != std::string::npos;
}

// The layers that the globs name, in the file's order per glob, without `of` and without repeats.
Result<std::vector<const ImageLayer*>> choose_layers(const ExrImage& image, const ImageLayer& of,
                                                     const std::vector<std::string>& globs) {
    std::vector<const ImageLayer*> chosen;
    for (const std::string& glob : globs) {
        bool matched = false;
        for (const ImageLayer& layer : image.layers) {
            if (!glob_match(glob, image.layer("beauty") == &layer ? "beauty" : layer.name)) continue;
            if (&layer == &of && has_wildcard(glob)) continue;
            if (&layer == &of)
                return split_error(image,
                                   "layer '" + glob + "' is the one summed to; expected layers that it splits into");
            matched = true;
            if (std::find(chosen.begin(), chosen.end(), &layer) == chosen.end()) chosen.push_back(&layer);
        }
        if (matched) continue;
        Error error =
            split_error(image, "no layer matches '" + glob + "'; expected one of: " + list_names(image.layer_names()));
        const std::string near = nearest_name(glob, image.layer_names());
        if (!near.empty()) error.hint = "did you mean '" + near + "'?";
        return error;
    }
    if (chosen.empty())
        return split_error(image, "no layers to sum; expected at least one of: " + list_names(image.layer_names()));
    return chosen;
}

Result<SplitVerdict> check_layers(const ExrImage& image, const ImageLayer& of,
                                  const std::vector<const ImageLayer*>& layers) {
    Result<std::array<const ImagePlane*, 3>> whole = summable(image, of);
    if (!whole) return std::move(whole).error();
    SplitSum sum(image.width, image.height);
    sum.add_whole(split_layer(*whole));
    std::vector<std::string> names;
    for (const ImageLayer* layer : layers) {
        Result<std::array<const ImagePlane*, 3>> planes = summable(image, *layer);
        if (!planes) return std::move(planes).error();
        sum.add(split_layer(*planes));
        names.push_back(layer->name.empty() ? "beauty" : layer->name);
    }
    SplitVerdict verdict = sum.verdict(true);
    verdict.of = of.name.empty() ? "beauty" : of.name;
    verdict.layers = std::move(names);
    return verdict;
}

}  // namespace

bool glob_match(std::string_view pattern, std::string_view name) {
    std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            resume = n;
        } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
            ++p;
            ++n;
        } else if (star != std::string_view::npos) {  // let the last * swallow one character more
            p = star + 1;
            n = ++resume;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

Result<SplitVerdict> check_split(const ExrImage& image, const std::string& of,
                                 const std::vector<std::string>& layer_globs) {
    Result<const ImageLayer*> whole = image.require_layer(of);
    if (!whole) return std::move(whole).error();
    Result<std::vector<const ImageLayer*>> layers = choose_layers(image, **whole, layer_globs);
    if (!layers) return std::move(layers).error();
    return check_layers(image, **whole, *layers);
}

Result<std::vector<SplitVerdict>> check_declared_splits(const ExrImage& image) {
    std::vector<SplitVerdict> verdicts;
    for (const PartitionDeclaration& partition : image.partitions) {
        const auto located = [&partition](Error error) {
            error.message = "partition '" + partition.name + "': " + error.message;
            return error;
        };
        if (partition.layers.empty())
            return located(
                split_error(image, "the header does not list its layers; expected \"beauty = first + second + ...\""));
        Result<const ImageLayer*> whole = image.require_layer(partition.of);
        if (!whole) return located(std::move(whole).error());
        std::vector<const ImageLayer*> layers;
        for (const std::string& name : partition.layers) {
            Result<const ImageLayer*> layer = image.require_layer(name);
            if (!layer) return located(std::move(layer).error());
            layers.push_back(*layer);
        }
        Result<SplitVerdict> verdict = check_layers(image, **whole, layers);
        if (!verdict) return located(std::move(verdict).error());
        verdict->partition = partition.name;
        verdicts.push_back(std::move(*verdict));
    }
    return verdicts;
}

}  // namespace raylex::display
