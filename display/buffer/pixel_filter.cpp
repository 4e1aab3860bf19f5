#include "display/buffer/pixel_filter.h"

#include <numbers>
#include <utility>

#include "display/services/elementary.h"
#include "display/services/short_number.h"

namespace raylex::display {
namespace {

constexpr int smooth_segments = 256;  // linear pieces; a Gaussian then deviates by at most 2e-5 at the centre

// The kernels. Formulas: M. Pharr, W. Jakob, G. Humphreys, Physically Based Rendering, 4th ed., section 8.8; for the
// Blackman-Harris window: F. J. Harris, "On the use of windows for harmonic analysis with the discrete Fourier
// transform", Proc. IEEE 66 (1978), 4-term minimum.

double normal_density(double x, double sigma) {
    return elementary::exp(-x * x / (2 * sigma * sigma)) / std::sqrt(2 * std::numbers::pi * sigma * sigma);
}

/// Mitchell and Netravali's piecewise cubic on [0, 2].
double mitchell(double x, double b, double c) {
    if (x <= 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
    if (x <= 2)
        return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
    return 0;
}

double sinc(double x) {
    return std::abs(x) < 1e-8 ? 1.0 : elementary::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

double blackman_harris(double x, double radius) {
    const double phase = std::numbers::pi * x / radius;
    return 0.35875 + 0.48829 * elementary::cos(phase) + 0.14128 * elementary::cos(2 * phase) +
           0.01168 * elementary::cos(3 * phase);
}

using RadiusProfile = std::function<double(double x, double radius)>;

ParameterDescription real_parameter(std::string name, std::string fallback, std::string help) {
    return {std::move(name), ParameterType::real, std::move(fallback), std::move(help)};
}

std::vector<ParameterDescription> radius_parameters(const std::string& fallback) {
    return {real_parameter("xradius", fallback, "half width, pixels, > 0"),
            real_parameter("yradius", fallback, "half height, pixels, > 0")};
}

Result<double> positive(const ParameterSet& parameters, std::string_view name, double fallback) {
    Result<double> value = parameters.real_or(name, fallback);
    if (!value) return value;
    if (!(*value > 0) || !(*value <= 64))
        return error_at(parameters.location, "pixel filter parameter '" + std::string(name) + "' is " +
                                                 short_number(*value, 6) + "; expected a value in (0, 64]");
    return value;
}

Result<PixelFilter> build(const std::string& name, const ParameterSet& parameters, double default_radius, int segments,
                          const RadiusProfile& profile) {
    const Result<double> radius_x = positive(parameters, "xradius", default_radius);
    if (!radius_x) return radius_x.error();
    const Result<double> radius_y = positive(parameters, "yradius", default_radius);
    if (!radius_y) return radius_y.error();
    const auto axis = [&](double radius) {
        return FilterProfile([&, radius](double x) { return profile(x, radius); }, radius, segments);
    };
    PixelFilter filter(name, axis(*radius_x), axis(*radius_y));
    if (!filter.valid())
        return error_at(parameters.location, "pixel filter '" + name +
                                                 "' with these parameters has no positive integral; expected a kernel "
                                                 "whose positive part is the larger one");
    return filter;
}

Result<PixelFilter> build_box(const ParameterSet& parameters) {
    return build("box", parameters, 0.5, 1, [](double, double) { return 1.0; });
}

Result<PixelFilter> build_triangle(const ParameterSet& parameters) {
    return build("triangle", parameters, 2.0, 1, [](double x, double radius) { return radius - x; });
}

Result<PixelFilter> build_gaussian(const ParameterSet& parameters) {
    const Result<double> sigma = positive(parameters, "sigma", 0.5);
    if (!sigma) return sigma.error();
    return build("gaussian", parameters, 1.5, smooth_segments, [s = *sigma](double x, double radius) {
        return std::max(0.0, normal_density(x, s) - normal_density(radius, s));
    });
}

Result<PixelFilter> build_mitchell(const ParameterSet& parameters) {
    const Result<double> b = parameters.real_or("B", 1.0 / 3.0);
    if (!b) return b.error();
    const Result<double> c = parameters.real_or("C", 1.0 / 3.0);
    if (!c) return c.error();
    return build("mitchell", parameters, 2.0, smooth_segments,
                 [bb = *b, cc = *c](double x, double radius) { return mitchell(2 * x / radius, bb, cc); });
}

// Not in pbrt. Its radius of 1.5 gives the 3 x 3 pixel footprint of pbrt's default Gaussian. Its standard deviation of
// 0.416 pixels makes it slightly sharper, and it falls to zero smoothly.
Result<PixelFilter> build_blackman_harris(const ParameterSet& parameters) {
    return build("blackman-harris", parameters, 1.5, smooth_segments, blackman_harris);
}

Result<PixelFilter> build_sinc(const ParameterSet& parameters) {
    const Result<double> tau = positive(parameters, "tau", 3.0);
    if (!tau) return tau.error();
    return build("sinc", parameters, 4.0, 4 * smooth_segments,
                 [t = *tau](double x, double) { return sinc(x) * sinc(x / t); });
}

std::vector<ParameterDescription> joined(std::vector<ParameterDescription> first,
                                         const std::vector<ParameterDescription>& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

Registry<PixelFilterFactory> in_tree_filters() {
    Registry<PixelFilterFactory> registry("pixel filter");
    registry.add({"box", "equal weights for all samples of the pixel", radius_parameters("0.5"), build_box});
    registry.add({"triangle", "falls linearly to zero at the radius", radius_parameters("2"), build_triangle});
    registry.add({"gaussian", "Gaussian, lowered to zero at the radius",
                  joined(radius_parameters("1.5"), {real_parameter("sigma", "0.5", "standard deviation, pixels, > 0")}),
                  build_gaussian});
    registry.add(
        {"mitchell", "Mitchell-Netravali cubic; has negative lobes",
         joined(radius_parameters("2"), {real_parameter("B", "0.3333333333333333", "blur; B + 2 C = 1 advised"),
                                         real_parameter("C", "0.3333333333333333", "ringing")}),
         build_mitchell});
    registry.add({"blackman-harris", "4-term Blackman-Harris window; like a Gaussian, no negative lobes",
                  radius_parameters("1.5"), build_blackman_harris});
    registry.add({"sinc", "Lanczos-windowed sinc; has negative lobes",
                  joined(radius_parameters("4"), {real_parameter("tau", "3", "cycles under the window, > 0")}),
                  build_sinc});
    return registry;
}

}  // namespace

FilterProfile::FilterProfile(const std::function<double(double)>& profile, double radius, int segments) {
    const auto count = static_cast<std::size_t>(segments);
    const double step = radius / segments;
    std::vector<double> values(count + 1);
    for (std::size_t i = 0; i <= count; ++i) values[i] = profile(static_cast<double>(i) * step);

    struct WidePiece {
        double start, width, left, right, sign;
    };
    std::vector<WidePiece> wide;
    for (std::size_t i = 0; i < count; ++i) {
        const double start = static_cast<double>(i) * step, a = values[i], b = values[i + 1];
        const auto sign = [](double value) { return value < 0 ? -1.0 : 1.0; };
        if (a * b < 0) {  // split where the linear piece crosses zero
            const double cut = step * (a / (a - b));
            wide.push_back({start, cut, std::abs(a), 0.0, sign(a)});
            wide.push_back({start + cut, step - cut, 0.0, std::abs(b), sign(b)});
        } else if (a != 0 || b != 0) {
            wide.push_back({start, step, std::abs(a), std::abs(b), sign(a + b)});
        }
    }
    double positive_part = 0, negative_part = 0;  // integrals over [0, radius]
    for (const WidePiece& piece : wide)
        (piece.sign > 0 ? positive_part : negative_part) += piece.width * (piece.left + piece.right) / 2;
    const double absolute = positive_part + negative_part, integral = positive_part - negative_part;
    // A kernel that nearly cancels would have unbounded weights (here: above 20), so it is invalid.
    if (!(integral > 0.05 * absolute) || !std::isfinite(absolute)) return;

    radius_ = static_cast<float>(radius);
    steps_per_pixel_ = static_cast<float>(1 / step);
    weight_ = negative_part == 0 ? 1.0f : static_cast<float>(absolute / integral);
    for (const double value : values) values_.push_back(static_cast<float>(value / (2 * integral)));
    double below = 0;
    for (const WidePiece& piece : wide) {
        pieces_.push_back({static_cast<float>(piece.start), static_cast<float>(piece.width),
                           static_cast<float>(below / absolute), static_cast<float>(piece.left / absolute),
                           static_cast<float>(piece.right / absolute), static_cast<float>(piece.sign)});
        below += piece.width * (piece.left + piece.right) / 2;
    }
    for (int i = 0; i < guide_size; ++i) {
        const float share = static_cast<float>(i) / guide_size;
        std::size_t piece = 0;
        while (piece + 1 < pieces_.size() && pieces_[piece + 1].below <= share) ++piece;
        guide_.push_back(static_cast<std::uint16_t>(piece));
    }
}

Registry<PixelFilterFactory>& pixel_filter_registry() {
    static Registry<PixelFilterFactory> registry = in_tree_filters();
    return registry;
}

Result<PixelFilter> make_pixel_filter(const std::string& name, const ParameterSet& parameters) {
    const Result<const Registry<PixelFilterFactory>::Entry*> entry =
        pixel_filter_registry().require(name, parameters.location);
    if (!entry) return entry.error();
    return (*entry)->factory(parameters);
}

}  // namespace raylex::display
