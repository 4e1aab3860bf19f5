// The metrics of `raylex compare`.
#include <algorithm>
#include <cmath>
#include <vector>

#include "display/output/primaries.h"
#include "display/output/split_check.h"

namespace raylex::display {

namespace {

// One layer as the metric sees it: what a component's value is at a pixel.
struct Side {
    std::array<const ImagePlane*, 3> planes{};
    Matrix3 to_reference = identity_matrix();
    bool color = false;  // R G B, not X Y Z or a single plane
    bool converts = false;

    [[nodiscard]] std::array<double, 3> at(std::size_t pixel) const {
        const std::array<double, 3> value{planes[0]->values[pixel], planes[1]->values[pixel], planes[2]->values[pixel]};
        return converts ? transform_colour(to_reference, value) : value;
    }
};

Result<Side> side_of(const ExrImage& image, const std::string& layer) {
    Result<const ImageLayer*> found = image.require_layer(layer);
    if (!found) return std::move(found).error();
    Side side;
    side.planes = (*found)->triple();
    side.color = (*found)->is_color();
    if (side.planes[0] != nullptr) return side;
    Error error;
    error.file = image.path;
    error.message = "layer '" + layer + "' cannot be compared: its " + std::to_string((*found)->planes.size()) +
                    " channels are neither R G B nor X Y Z nor a single one";
    return error;
}

bool is_component(char component) {
    return std::string_view("RGBYA").find(component) != std::string_view::npos;
}

Error compare_error(const ExrImage& image, const std::string& message) {
    Error error;
    error.file = image.path;
    error.message = message;
    return error;
}

/// How many of `values` are no finite numbers, those aside that are the same infinity in `others`: metrics leave these out.
std::size_t count_not_finite(const std::vector<double>& values, const std::vector<double>& others) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
        count += !std::isfinite(values[i]) && !(std::isinf(values[i]) && values[i] == others[i]) ? 1 : 0;
    return count;
}

/// Why a metric of these values is no number: what divides is 0, or one of the images holds what is no number itself.
Error no_value(const ExrImage& image, const ExrImage& reference, ErrorMetric metric, const std::string& layer,
               const std::vector<double>& values, const std::vector<double>& expected) {
    const std::size_t of_image = count_not_finite(values, expected), of_reference = count_not_finite(expected, values);
    if (metric == ErrorMetric::mean_ratio && of_image == 0 && of_reference == 0) {
        Error error = compare_error(reference, "there is no ratio " + std::string(formula(metric)) + ": the mean of '" +
                                                   layer + "' is 0 in this reference");
        error.hint = "metrics of differences, such as mae, have a value for black layers too";
        return error;
    }
    const ExrImage& bad = of_reference == 0 ? image : reference;
    return compare_error(bad, std::string(error_metrics()[static_cast<std::size_t>(metric)].name) + " of layer '" +
                                  layer + "' has no value: " + std::to_string(of_reference == 0 ? of_image : of_reference) + " of its " +
                                  std::to_string(values.size()) + " values are inf or nan");
}

}  // namespace

Result<double> compare(const ExrImage& image, const ExrImage& reference, ErrorMetric metric, const std::string& layer,
                       char component) {
    if (!is_component(component))
        return compare_error(image, std::string("unknown component '") + component + "'; expected R, G, B, Y or A");
    if (image.width != reference.width || image.height != reference.height)
        return compare_error(image, "the image has " + std::to_string(image.width) + " x " +
                                        std::to_string(image.height) + " pixels; expected " +
                                        std::to_string(reference.width) + " x " + std::to_string(reference.height) +
                                        " as in " + reference.path);
    Result<Side> a = side_of(image, layer), b = side_of(reference, layer);
    if (!a) return std::move(a).error();
    if (!b) return std::move(b).error();

    const bool color = a->color && b->color;
    const Chromaticities from = image.chromaticities.value_or(rec709_primaries()),
                         to = reference.chromaticities.value_or(rec709_primaries());
    a->converts = color && !equivalent(from, to);
    if (a->converts) a->to_reference = rgb_to_rgb(from, to);
    const std::array<double, 3> weights = luminance_weights(to);
    const bool positions = !color && a->planes[0] != a->planes[1];

    const std::size_t pixels = a->planes[0]->values.size();
    std::vector<double> values, expected;
    values.reserve(pixels * (component == 'A' ? 3 : 1));
    expected.reserve(values.capacity());
    const auto add = [&values, &expected](double value, double reference_value) {
        values.push_back(value);
        expected.push_back(reference_value);
    };
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        const std::array<double, 3> p = a->at(pixel), q = b->at(pixel);
        if (component == 'A') {
            for (std::size_t c = 0; c < 3; ++c) add(p[c], q[c]);
        } else if (component == 'Y' && color) {
            add(weights[0] * p[0] + weights[1] * p[1] + weights[2] * p[2],
                weights[0] * q[0] + weights[1] * q[1] + weights[2] * q[2]);
        } else {
            const std::size_t index = component == 'G' || (component == 'Y' && positions) ? 1
                                      : component == 'B'                                  ? 2
                                                                                          : 0;
            add(p[index], q[index]);
        }
    }
    const double value = measure_errors(values, expected)[metric];
    const bool divides_by_zero = metric == ErrorMetric::mean_ratio && !std::isfinite(value);
    if (std::isnan(value) || divides_by_zero) return no_value(image, reference, metric, layer, values, expected);
    return value;
}

}  // namespace raylex::display
