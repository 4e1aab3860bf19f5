// The metrics of `raylex compare`.
#include <cmath>

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

// The sums a metric needs, over all pixels and chosen components.
struct Sums {
    double squared = 0, absolute = 0, relative_squared = 0, relative_absolute = 0, image = 0, reference = 0;
    double count = 0;

    void add(double a, double b) {
        count += 1;
        if (std::isinf(a) && a == b) return;
        const double difference = a - b;
        squared += difference * difference;
        absolute += std::abs(difference);
        relative_squared += difference * difference / (b * b + 0.01);
        relative_absolute += std::abs(difference) / (std::abs(b) + 0.01);
        image += a;
        reference += b;
    }
    [[nodiscard]] double value(CompareMetric metric) const {
        switch (metric) {
            case CompareMetric::relmse:
                return relative_squared / count;
            case CompareMetric::mse:
                return squared / count;
            case CompareMetric::mae:
                return absolute / count;
            case CompareMetric::mape:
                return relative_absolute / count;
            case CompareMetric::mean_ratio:
                return image / reference;
        }
        return 0;
    }
};

bool is_component(char component) {
    return std::string_view("RGBYA").find(component) != std::string_view::npos;
}

Error compare_error(const ExrImage& image, const std::string& message) {
    Error error;
    error.file = image.path;
    error.message = message;
    return error;
}

}  // namespace

const char* formula(CompareMetric metric) {
    switch (metric) {
        case CompareMetric::relmse:
            return "mean((a-b)^2 / (b^2 + 0.01))";
        case CompareMetric::mse:
            return "mean((a-b)^2)";
        case CompareMetric::mae:
            return "mean(|a-b|)";
        case CompareMetric::mape:
            return "mean(|a-b| / (|b| + 0.01))";
        case CompareMetric::mean_ratio:
            return "mean(a) / mean(b)";
    }
    return "";
}

Result<double> compare(const ExrImage& image, const ExrImage& reference, CompareMetric metric, const std::string& layer,
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

    Sums sums;
    const std::size_t pixels = a->planes[0]->values.size();
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        const std::array<double, 3> p = a->at(pixel), q = b->at(pixel);
        if (component == 'A') {
            for (std::size_t c = 0; c < 3; ++c) sums.add(p[c], q[c]);
        } else if (component == 'Y' && color) {
            sums.add(weights[0] * p[0] + weights[1] * p[1] + weights[2] * p[2],
                     weights[0] * q[0] + weights[1] * q[1] + weights[2] * q[2]);
        } else {
            const std::size_t index = component == 'G' || (component == 'Y' && positions) ? 1
                                      : component == 'B'                                  ? 2
                                                                                          : 0;
            sums.add(p[index], q[index]);
        }
    }
    return sums.value(metric);
}

}  // namespace raylex::display
