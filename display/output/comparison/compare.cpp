// The metrics of `raylex compare`.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "display/output/color/primaries.h"
#include "display/output/comparison/comparison.h"
#include "display/output/metrics/error_terms.h"
#include "display/output/splits/split_check.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

Result<const ImageLayer*> comparable_layer(const ExrImage& image, const std::string& layer) {
    Result<const ImageLayer*> found = image.require_layer(layer);
    if (!found || (*found)->triple()[0] != nullptr) return found;
    return error_at({image.path, 0, 0}, "layer '" + layer + "' cannot be compared: its " +
                                            std::to_string((*found)->planes.size()) +
                                            " channels are neither R G B nor X Y Z nor a single one");
}

/// Counts the values that are not finite, because metrics of values exclude them. If `equal_allowed`, infinities that
/// are equal in `others` do not count.
std::size_t count_not_finite(const std::vector<double>& values, const std::vector<double>& others, bool equal_allowed) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool alike = equal_allowed && std::isinf(values[i]) && values[i] == others[i];
        count += !std::isfinite(values[i]) && !alike ? 1 : 0;
    }
    return count;
}

std::vector<double> interleaved(const ImageLayer& layer, const Matrix3* conversion) {
    const std::array<const ImagePlane*, 3> planes = layer.triple();
    std::vector<double> values;
    values.reserve(planes[0]->values.size() * 3);
    for (std::size_t i = 0; i < planes[0]->values.size(); ++i) {
        std::array<double, 3> pixel{planes[0]->values[i], planes[1]->values[i], planes[2]->values[i]};
        if (conversion != nullptr) pixel = transform_colour(*conversion, pixel);
        values.insert(values.end(), pixel.begin(), pixel.end());
    }
    return values;
}

}  // namespace

LinearImage in_rec709(int width, int height, std::vector<double> rgb, const Chromaticities& from) {
    LinearImage image{width, height, std::move(rgb)};
    if (equivalent(from, rec709_primaries())) return image;
    const Matrix3 matrix = rgb_to_rgb(from, rec709_primaries());
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
        const std::array<double, 3> pixel =
            transform_colour(matrix, {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]});
        std::copy(pixel.begin(), pixel.end(), image.rgb.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return image;
}

std::vector<AnyMetric> all_metrics() {
    std::vector<AnyMetric> all;
    for (const ErrorMetricInfo& each : error_metrics()) all.push_back({each.name, each.formula, each.metric, {}});
    for (const ImageMetricInfo& each : image_metrics()) all.push_back({each.name, each.formula, {}, each.metric});
    return all;
}

std::optional<AnyMetric> find_metric(std::string_view name) {
    std::string hyphens(name);  // names in Python have underscores
    std::replace(hyphens.begin(), hyphens.end(), '_', '-');
    for (AnyMetric& each : all_metrics())
        if (each.name == hyphens) return std::move(each);
    return std::nullopt;
}

Result<AnyMetric> require_metric(const std::string& name, const SourceLocation& where,
                                 const std::vector<std::string>& beside) {
    if (auto found = find_metric(name)) return *std::move(found);
    std::vector<std::string> names;
    for (const AnyMetric& each : all_metrics()) names.push_back(each.name);
    names.insert(names.end(), beside.begin(), beside.end());
    std::string list;
    for (const std::string& each : names) list += (list.empty() ? "" : ", ") + each;
    return error_at(where, "unknown metric '" + name + "'; expected one of: " + list, near_miss(name, names));
}

Result<LayerPair> LayerPair::make(const ExrImage& image, const ExrImage& reference, const std::string& layer) {
    if (image.width != reference.width || image.height != reference.height)
        return error_at({image.path, 0, 0}, "the image has " + std::to_string(image.width) + " x " +
                                                std::to_string(image.height) + " pixels; expected " +
                                                std::to_string(reference.width) + " x " +
                                                std::to_string(reference.height) + " as in " + reference.path);
    if (image.width <= 0 || image.height <= 0)
        return error_at({image.path, 0, 0}, "the image has no pixels; expected at least one");
    const Result<const ImageLayer*> a = comparable_layer(image, layer), b = comparable_layer(reference, layer);
    if (!a) return a.error();
    if (!b) return b.error();
    LayerPair pair;
    pair.layer_ = layer;
    pair.image_path_ = image.path;
    pair.reference_path_ = reference.path;
    pair.width_ = image.width;
    pair.height_ = image.height;
    pair.color_ = (*a)->is_color() && (*b)->is_color();
    pair.single_ = (*a)->triple()[0] == (*a)->triple()[1];
    pair.primaries_ = reference.chromaticities.value_or(rec709_primaries());
    pair.luminance_ = luminance_weights(pair.primaries_);
    const Chromaticities from = image.chromaticities.value_or(rec709_primaries());
    const Matrix3 matrix = rgb_to_rgb(from, pair.primaries_);
    const bool converts = pair.color_ && !equivalent(from, pair.primaries_);
    pair.image_ = interleaved(**a, converts ? &matrix : nullptr);
    pair.reference_ = interleaved(**b, nullptr);
    return pair;
}

Result<LayerPair::Values> LayerPair::values_of(char component) const {
    if (std::string_view("RGBYA").find(component) == std::string_view::npos)
        return error_at({image_path_, 0, 0},
                        std::string("unknown component '") + component + "'; expected R, G, B, Y or A");
    if (component == 'A') return Values{image_, reference_, 3};
    Values values;
    const std::size_t index = component == 'G' || (component == 'Y' && !color_ && !single_) ? 1
                              : component == 'B'                                            ? 2
                                                                                            : 0;
    const auto pick = [&](const std::vector<double>& from, std::vector<double>& to) {
        to.reserve(from.size() / 3);
        for (std::size_t i = 0; i < from.size(); i += 3)
            to.push_back(component == 'Y' && color_
                             ? luminance_[0] * from[i] + luminance_[1] * from[i + 1] + luminance_[2] * from[i + 2]
                             : from[i + index]);
    };
    pick(image_, values.image);
    pick(reference_, values.reference);
    return values;
}

/// An error if the metric of these values is not a number, because one of the images has values that are not.
std::optional<Error> LayerPair::not_finite(const std::string& metric, const Values& values, bool equal_allowed) const {
    const std::size_t of_image = count_not_finite(values.image, values.reference, equal_allowed),
                      of_reference = count_not_finite(values.reference, values.image, equal_allowed);
    if (of_image == 0 && of_reference == 0) return std::nullopt;
    const std::string& bad = of_reference == 0 ? image_path_ : reference_path_;
    return error_at({bad, 0, 0}, metric + " of layer '" + layer_ +
                                     "' has no value: " + std::to_string(of_reference == 0 ? of_image : of_reference) +
                                     " of its " + std::to_string(values.image.size()) + " values are inf or nan");
}

Result<double> LayerPair::value(const AnyMetric& metric, char component) const {
    if (metric.of_image) {
        auto seen = look(metric, component);
        if (!seen) return seen.error();
        return seen->value;
    }
    Result<Values> values = values_of(component);
    if (!values) return values.error();
    const double value = measure_errors(values->image, values->reference)[*metric.of_values];
    const bool ratio = *metric.of_values == ErrorMetric::mean_ratio;
    if (!std::isnan(value) && !(ratio && !std::isfinite(value))) return value;
    if (auto why = not_finite(metric.name, *values, true)) return std::move(*why);
    if (ratio) {
        Error error = error_at({reference_path_, 0, 0}, "there is no ratio " + metric.formula + ": the mean of '" +
                                                            layer_ + "' is 0 in this reference");
        error.hint = "metrics of differences, such as mae, have a value for black layers too";
        return error;
    }
    return error_at({reference_path_, 0, 0},
                    metric.name + " of layer '" + layer_ + "' has no value: its values are inf or nan");
}

Result<ImageErrors> LayerPair::look(const AnyMetric& metric, char component) const {
    if (component != 'A')
        return error_at({image_path_, 0, 0}, metric.name + " needs whole colours, not component " +
                                                 std::string(1, component) + "; expected no --channel with it");
    if (!color_ && !single_)
        return error_at({image_path_, 0, 0}, metric.name + " needs colours, and layer '" + layer_ +
                                                 "' has none; expected a layer of R G B, or of a single channel");
    if (auto why = not_finite(metric.name, {image_, reference_, 3}, false)) return std::move(*why);
    const Chromaticities from = color_ ? primaries_ : rec709_primaries();
    return measure_image(*metric.of_image, in_rec709(width_, height_, image_, from),
                         in_rec709(width_, height_, reference_, from));
}

Result<ImageErrors> LayerPair::errors(const AnyMetric& metric, char component) const {
    if (metric.of_image) return look(metric, component);
    const Result<double> number = value(metric, component);
    if (!number) return number.error();
    Result<Values> values = values_of(component);
    if (!values) return values.error();
    const std::vector<double> terms = error_terms(*metric.of_values, values->image, values->reference);
    if (terms.empty())
        return error_at({image_path_, 0, 0},
                        metric.name + " is " + metric.formula +
                            ", which is not defined for single pixels; expected another metric for an error image");
    ImageErrors result;
    result.value = *number;
    for (std::size_t i = 0; i < terms.size(); i += values->per_pixel) {
        double sum = 0;
        for (std::size_t c = 0; c < values->per_pixel; ++c) sum += terms[i + c];
        const double mean = sum / static_cast<double>(values->per_pixel);
        result.map.push_back(*metric.of_values == ErrorMetric::rmse ? std::sqrt(mean) : mean);
    }
    return result;
}

Result<double> compare(const ExrImage& image, const ExrImage& reference, ErrorMetric metric, const std::string& layer,
                       char component) {
    const Result<LayerPair> pair = LayerPair::make(image, reference, layer);
    if (!pair) return pair.error();
    const ErrorMetricInfo& info = error_metrics()[static_cast<std::size_t>(metric)];
    return pair->value({info.name, info.formula, metric, {}}, component);
}

}  // namespace raylex::display
