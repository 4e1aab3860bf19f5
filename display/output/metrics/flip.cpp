// Implemented from the two publications; numbers of equations and tables refer to them.
#include "display/output/metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "display/output/color/primaries.h"
#include "display/output/metrics/image_filters.h"
#include "display/services/elementary.h"

namespace raylex::display {

namespace {

using Color = std::array<double, 3>;

/// Three planes of equal size: Y Cx Cz, or R G B.
using Planes = std::array<Plane, 3>;

/// The matrices between linear R G B and XYZ, and the reference white of L*a*b* and Y Cx Cz.
struct Space {
    Matrix3 to_xyz = rgb_to_xyz(rec709_primaries()), from_xyz = inverse(rgb_to_xyz(rec709_primaries()));
    Color white = transform_colour(to_xyz, {1, 1, 1});
};

const Space& space() {
    static const Space only;
    return only;
}

/// L*a*b* without its cube roots, so that filters stay linear in light.
Color to_ycxcz(const Color& rgb) {
    const Color xyz = transform_colour(space().to_xyz, rgb), &n = space().white;
    const double x = xyz[0] / n[0], y = xyz[1] / n[1], z = xyz[2] / n[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Color from_ycxcz(const Color& value) {
    const Color& n = space().white;
    const double y = (value[0] + 16) / 116, x = value[1] / 500 + y, z = y - value[2] / 200;
    return transform_colour(space().from_xyz, {x * n[0], y * n[1], z * n[2]});
}

/// CIE 1976 L*a*b* with a* and b* scaled for the Hunt effect: dark colours appear less colourful (section 4.1.2).
Color to_hunt_lab(const Color& rgb) {
    const Color xyz = transform_colour(space().to_xyz, rgb), &n = space().white;
    constexpr double delta = 6.0 / 29;
    const auto root = [](double t) {
        return t > delta * delta * delta ? elementary::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
    };
    const double x = root(xyz[0] / n[0]), y = root(xyz[1] / n[1]), z = root(xyz[2] / n[2]);
    const double lightness = 116 * y - 16;
    return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

/// The city-block distance of lightness plus the Euclidean distance of chroma.
double hyab(const Color& p, const Color& q) {
    return std::abs(p[0] - q[0]) + elementary::hypot(p[1] - q[1], p[2] - q[2]);
}

constexpr double qc = 0.7, pc = 0.4, pt = 0.95, qf = 0.5;

/// Maps colour differences to 0..1: those up to pc of the largest possible difference use pt of the range (equation
/// 10).
double redistributed(double difference, double largest) {
    const double knee = pc * largest;
    return difference < knee ? pt / knee * difference : pt + (difference - knee) / (largest - knee) * (1 - pt);
}

/// A contrast sensitivity function in the spatial domain: a sum of two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x
/// in degrees (equation 6, table 1).
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> sensitivities{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

double deviation_of(double b) {
    return std::sqrt(b / 2) / std::numbers::pi;  // degrees
}

Plane seen(const Plane& plane, const Sensitivity& sensitivity) {
    constexpr double widest = 0.04;
    const int radius = static_cast<int>(std::ceil(3 * deviation_of(widest) * flip_pixels_per_degree));
    const auto kernel = [radius](double b) { return gaussian(deviation_of(b) * flip_pixels_per_degree, radius); };
    const auto weight = [](double a, double b, const Kernel& k) {
        double sum = 0;
        for (const double each : k) sum += each;
        return a * std::sqrt(std::numbers::pi / b) * sum * sum;
    };
    const Kernel first = kernel(sensitivity.b1);
    Plane result = filtered(plane, normalised(first), normalised(first), Border::repeats);
    if (sensitivity.a2 == 0) return result;
    const Kernel second = kernel(sensitivity.b2);
    const Plane other = filtered(plane, normalised(second), normalised(second), Border::repeats);
    const double w1 = weight(sensitivity.a1, sensitivity.b1, first),
                 w2 = weight(sensitivity.a2, sensitivity.b2, second);
    for (std::size_t i = 0; i < result.size(); ++i)
        result.values[i] = (w1 * result.values[i] + w2 * other.values[i]) / (w1 + w2);
    return result;
}

/// Scales positive weights to a sum of 1, and negative weights to a sum of -1.
Kernel balanced(Kernel kernel) {
    double positive = 0, negative = 0;
    for (const double each : kernel) (each > 0 ? positive : negative) += each;
    for (double& each : kernel) each /= each > 0 ? positive : -negative;
    return kernel;
}

/// The strength of each pixel as an edge (first derivative of a Gaussian) and as a point (second derivative), section
/// 4.2.
std::pair<Plane, Plane> features(const Plane& achromatic) {
    constexpr double width = 0.082;  // degrees
    const double deviation = 0.5 * width * flip_pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    const Kernel smooth = gaussian(deviation, radius);
    Kernel edge = smooth, point = smooth;
    for (int x = -radius; x <= radius; ++x) {
        const auto i = static_cast<std::size_t>(x + radius);
        edge[i] *= -x;
        point[i] *= x * x / (deviation * deviation) - 1;
    }
    const auto strength = [&](const Kernel& derivative) {
        const Kernel along = balanced(derivative), beside = normalised(smooth);
        Plane across = filtered(achromatic, along, beside, Border::repeats);
        const Plane down = filtered(achromatic, beside, along, Border::repeats);
        for (std::size_t i = 0; i < across.size(); ++i)
            across.values[i] = elementary::hypot(across.values[i], down.values[i]);
        return across;
    };
    return {strength(edge), strength(point)};
}

/// One image after preprocessing: its colours as the eye resolves them, and its features.
struct View {
    std::vector<Color> lab;
    Plane edges, points;
};

View view_of(const LinearImage& image) {
    const Plane empty(image.width, image.height);
    Planes planes{empty, empty, empty};
    Plane achromatic = empty;
    for (std::size_t i = 0; i < empty.size(); ++i) {
        Color rgb{};
        for (std::size_t c = 0; c < 3; ++c) rgb[c] = std::clamp(image.rgb[3 * i + c], 0.0, 1.0);
        const Color value = to_ycxcz(rgb);
        for (std::size_t c = 0; c < 3; ++c) planes[c].values[i] = value[c];
        achromatic.values[i] = (value[0] + 16) / 116;
    }
    auto [edges, points] = features(achromatic);
    View view{std::vector<Color>(empty.size()), std::move(edges), std::move(points)};
    for (std::size_t c = 0; c < 3; ++c) planes[c] = seen(planes[c], sensitivities[c]);
    for (std::size_t i = 0; i < empty.size(); ++i) {
        Color rgb = from_ycxcz({planes[0].values[i], planes[1].values[i], planes[2].values[i]});
        for (double& each : rgb) each = std::clamp(each, 0.0, 1.0);
        view.lab[i] = to_hunt_lab(rgb);
    }
    return view;
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double each : values) sum += each;
    return sum / static_cast<double>(values.size());
}

/// Narkowicz's fit to the ACES view, for linear values without a previous exposure by 0.6.
struct Curve {
    double a = 0.36 * 2.51, b = 0.6 * 0.03, c = 0.36 * 2.43, d = 0.6 * 0.59, e = 0.14;
    [[nodiscard]] double operator()(double x) const {
        x = std::max(x, 0.0);
        return std::clamp(x * (a * x + b) / (x * (c * x + d) + e), 0.0, 1.0);
    }
    /// The value that the curve maps to t.
    [[nodiscard]] double shown_as(double t) const {
        const double p = a - t * c, q = b - t * d, r = -t * e;
        return (-q + std::sqrt(q * q - 4 * p * r)) / (2 * p);
    }
};

/// The exposures in stops, from the darkest picture to the brightest.
std::vector<double> exposures_for(const LinearImage& reference) {
    const std::array<double, 3> weights = luminance_weights(rec709_primaries());
    std::vector<double> luminances;
    for (std::size_t i = 0; i < reference.rgb.size(); i += 3)
        luminances.push_back(weights[0] * reference.rgb[i] + weights[1] * reference.rgb[i + 1] +
                             weights[2] * reference.rgb[i + 2]);
    const double brightest = *std::max_element(luminances.begin(), luminances.end());
    if (brightest <= 0) return {0};
    const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>((luminances.size() - 1) / 2);
    std::nth_element(luminances.begin(), middle, luminances.end());
    const double median = std::max(*middle, brightest * 0x1p-23);
    constexpr double shown = 0.85;
    const double value = Curve().shown_as(shown);
    const double start = elementary::log2(value / brightest), stop = elementary::log2(value / median);
    const int count = std::max(2, static_cast<int>(std::ceil(stop - start)));
    std::vector<double> stops;
    for (int i = 0; i < count; ++i) stops.push_back(start + i * (stop - start) / (count - 1));
    return stops;
}

LinearImage exposed(const LinearImage& image, double stops) {
    LinearImage result = image;
    const double factor = elementary::exp2(stops);
    const Curve curve;
    for (double& each : result.rgb) each = curve(each * factor);
    return result;
}

}  // namespace

ImageErrors measure_flip(const LinearImage& image, const LinearImage& reference) {
    const View a = view_of(image), b = view_of(reference);
    const double largest = elementary::pow(hyab(to_hunt_lab({0, 1, 0}), to_hunt_lab({0, 0, 1})), qc);
    ImageErrors result;
    result.map.resize(a.lab.size());
    for (std::size_t i = 0; i < a.lab.size(); ++i) {
        const double color = redistributed(elementary::pow(hyab(a.lab[i], b.lab[i]), qc), largest);
        const double feature = std::max(std::abs(a.edges.values[i] - b.edges.values[i]),
                                        std::abs(a.points.values[i] - b.points.values[i]));
        result.map[i] = elementary::pow(color, 1 - elementary::pow(feature / std::numbers::sqrt2, qf));
    }
    result.value = mean(result.map);
    return result;
}

ImageErrors measure_hdr_flip(const LinearImage& image, const LinearImage& reference) {
    ImageErrors result;
    result.map.resize(image.rgb.size() / 3);
    for (const double stops : exposures_for(reference)) {
        const ImageErrors one = measure_flip(exposed(image, stops), exposed(reference, stops));
        for (std::size_t i = 0; i < result.map.size(); ++i) result.map[i] = std::max(result.map[i], one.map[i]);
    }
    result.value = mean(result.map);
    return result;
}

}  // namespace raylex::display
