#include "display/output/split_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "display/output/exr_layers.h"
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

struct Split {
    std::vector<std::array<const ImagePlane*, 3>> layers;
    std::array<const ImagePlane*, 3> of{};
    double unit = 0;     // u
    double spacing = 0;  // of subnormal numbers, summed over all values of a pixel's component
};

double unit_of(StoredType type) {
    return type == StoredType::half_float ? 0x1p-10 : 0x1p-23;
}
double spacing_of(StoredType type) {
    return type == StoredType::half_float ? 0x1p-24 : 0x1p-149;
}

void note_types(Split& split, const std::array<const ImagePlane*, 3>& planes) {
    double spacing = 0;
    for (const ImagePlane* plane : planes) {
        split.unit = std::max(split.unit, unit_of(plane->stored));
        spacing = std::max(spacing, spacing_of(plane->stored));
    }
    split.spacing += spacing;
}

struct Difference {
    double absolute = 0, relative = 0;
    bool finite = true, exceeds = false;
};

Difference difference_at(const Split& split, std::size_t component, std::size_t pixel) {
    const double whole = split.of[component]->values[pixel];
    double sum = 0, scale = std::abs(whole);
    for (const auto& layer : split.layers) {
        const double value = layer[component]->values[pixel];
        sum += value;
        scale += std::abs(value);
    }
    Difference result;
    result.finite = std::isfinite(scale);
    if (!result.finite) return result;
    result.absolute = std::abs(sum - whole);
    result.relative = scale > 0 ? result.absolute / scale : 0.0;
    result.exceeds = result.absolute > split.unit * scale + split.spacing;
    if (!result.exceeds) result.relative = std::min(result.relative, split.unit);
    return result;
}

void judge(const ExrImage& image, const Split& split, SplitVerdict& verdict) {
    verdict.bound = split.unit;
    const auto width = static_cast<std::size_t>(image.width);
    verdict.residual.resize(width * static_cast<std::size_t>(image.height));
    for (std::size_t pixel = 0; pixel < verdict.residual.size(); ++pixel) {
        const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
        bool finite = true, exceeds = false;
        double worst = 0;
        for (std::size_t component = 0; component < 3; ++component) {
            const Difference difference = difference_at(split, component, pixel);
            finite = finite && difference.finite;
            exceeds = exceeds || difference.exceeds;
            worst = std::max(worst, difference.relative);
            if (difference.absolute > verdict.largest_absolute) {
                verdict.largest_absolute = difference.absolute;
                verdict.absolute_x = x;
                verdict.absolute_y = y;
            }
            if (difference.relative > verdict.largest_relative) {
                verdict.largest_relative = difference.relative;
                verdict.relative_x = x;
                verdict.relative_y = y;
            }
        }
        if (!finite && verdict.non_finite++ == 0) {
            verdict.non_finite_x = x;
            verdict.non_finite_y = y;
        }
        verdict.exceeding += finite && exceeds ? 1 : 0;
        verdict.residual[pixel] = finite ? static_cast<float>(worst) : std::numeric_limits<float>::infinity();
    }
    verdict.holds = verdict.non_finite == 0 && verdict.exceeding == 0;
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
    Split split;
    Result<std::array<const ImagePlane*, 3>> whole = summable(image, of);
    if (!whole) return std::move(whole).error();
    split.of = *whole;
    note_types(split, split.of);
    SplitVerdict verdict;
    verdict.of = of.name.empty() ? "beauty" : of.name;
    for (const ImageLayer* layer : layers) {
        Result<std::array<const ImagePlane*, 3>> planes = summable(image, *layer);
        if (!planes) return std::move(planes).error();
        split.layers.push_back(*planes);
        note_types(split, *planes);
        verdict.layers.push_back(layer->name.empty() ? "beauty" : layer->name);
    }
    judge(image, split, verdict);
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
