// Statistics and quadrature that the tests of materials share.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "display/services/split_mix.h"
#include "transport/materials/closures/closure.h"
#include "transport/math/sampling.h"

namespace raylex::test {

using transport::Bsdf;
using transport::Frame;
using transport::Vec2;
using transport::Vec3;

/// Random numbers with fixed seeds: a test that passes once passes always.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * raylex::golden_gamma + 1) {}
    float one() { return transport::unit_float(raylex::mix_bits(state_ += raylex::golden_gamma)); }
    Vec2 two() {
        const float x = one();
        return {x, one()};
    }
    std::uint32_t bits() { return static_cast<std::uint32_t>(raylex::mix_bits(state_ += raylex::golden_gamma)); }

  private:
    std::uint64_t state_;
};

/// A rotated frame, so that tests detect a closure that does not transform to its local frame.
inline Frame tilted_frame() {
    return Frame::from_normal_and_tangent(transport::normalize({0.3f, -0.5f, 0.8f}), {0.6f, 0.7f, 0.1f});
}

inline Vec3 local_direction(float cos_theta, float phi = 0.7f) {
    const float s = transport::safe_sqrt(1 - cos_theta * cos_theta);
    return {s * std::cos(phi), s * std::sin(phi), cos_theta};
}

/// Reflectance of a smooth interface by Snell's law and Fresnel's equations.
inline double fresnel_by_snell(double cos_i, double n_i, double n_t) {
    const double sin_t = n_i / n_t * std::sqrt(1 - cos_i * cos_i);
    if (sin_t >= 1) return 1;
    const double cos_t = std::sqrt(1 - sin_t * sin_t);
    const double s = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t);
    const double p = (n_i * cos_t - n_t * cos_i) / (n_i * cos_t + n_t * cos_i);
    return (s * s + p * p) / 2;
}

/// Upper tail of the chi-square distribution: the regularised incomplete gamma function Q(dof/2, x/2).
inline double chi_square_tail(double x, double dof) {
    const double a = dof / 2, y = x / 2;
    if (y <= 0) return 1;
    const double front = std::exp(a * std::log(y) - y - std::lgamma(a));
    if (y < a + 1) {
        double term = 1 / a, sum = term;
        for (int n = 1; n < 1000; ++n) sum += term *= y / (a + n);
        return 1 - front * sum;
    }
    double b = y + 1 - a, c = 1e300, d = 1 / b, h = d;  // Lentz's continued fraction
    for (int n = 1; n < 1000; ++n) {
        const double an = -n * (n - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= d * c;
    }
    return front * h;
}

/// Cells of a sphere about an axis. The polar angle is warped so that a lobe of width `scale` around the axis covers
/// half of them: t = theta / (theta + scale), scaled to reach 1 at theta = pi.
class LobeGrid {
  public:
    LobeGrid(const Vec3& axis, float scale, int rings, int sectors)
        : frame_(Frame::from_normal(axis)), scale_(scale), rings_(rings), sectors_(sectors) {}

    [[nodiscard]] int size() const { return rings_ * sectors_; }
    [[nodiscard]] int cell(const Vec3& w) const {
        const Vec3 l = frame_.to_local(w);
        const double theta =
            std::atan2(std::hypot(static_cast<double>(l.x), static_cast<double>(l.y)), static_cast<double>(l.z));
        const double t = theta / (theta + scale_) * (pi_ + scale_) / pi_;
        double phi = std::atan2(l.y, l.x) / (2 * pi_);
        if (phi < 0) phi += 1;
        const int ring = std::min(static_cast<int>(t * rings_), rings_ - 1);
        return ring * sectors_ + std::min(static_cast<int>(phi * sectors_), sectors_ - 1);
    }
    /// Integrals of `f` over every cell by the midpoint rule on `n` x `n` points each.
    [[nodiscard]] std::vector<double> integrate(const std::function<double(const Vec3&)>& f, int n) const {
        std::vector<double> result(static_cast<std::size_t>(size()));
        const double top = pi_ / (pi_ + scale_);
        for (int i = 0; i < rings_ * n; ++i) {
            const double t = (i + 0.5) / (rings_ * n) * top, theta = scale_ * t / (1 - t);
            const double width = scale_ / ((1 - t) * (1 - t)) * top / (rings_ * n);
            const double area = std::sin(theta) * width * 2 * pi_ / (sectors_ * n);
            for (int j = 0; j < sectors_ * n; ++j) {
                const double phi = 2 * pi_ * (j + 0.5) / (sectors_ * n);
                const Vec3 w = frame_.to_world({static_cast<float>(std::sin(theta) * std::cos(phi)),
                                                static_cast<float>(std::sin(theta) * std::sin(phi)),
                                                static_cast<float>(std::cos(theta))});
                result[static_cast<std::size_t>(i / n * sectors_ + j / n)] += f(w) * area;
            }
        }
        return result;
    }

  private:
    static constexpr double pi_ = std::numbers::pi;
    Frame frame_;
    double scale_;
    int rings_, sectors_;
};

/// Mean over the upper hemisphere of `f` times cos / pi's weight: the integral of f(w) dw, by stratified sampling.
inline double integrate_hemisphere(const std::function<double(const Vec3&)>& f, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Vec2 u{(static_cast<float>(i) + 0.5f) / static_cast<float>(n),
                         (static_cast<float>(j) + 0.5f) / static_cast<float>(n)};
            const Vec3 w = transport::sample_cosine_hemisphere(u);
            sum += f(w) * transport::pi / static_cast<double>(w.z);
        }
    return sum / (static_cast<double>(n) * n);
}

struct MeanAndError {
    double mean = 0, standard_error = 0;
};

/// Mean of `n` calls of `draw`, with its standard error.
inline MeanAndError average(int n, const std::function<double()>& draw) {
    double mean = 0, m2 = 0;
    for (int i = 0; i < n; ++i) {
        const double x = draw(), delta = x - mean;
        mean += delta / (i + 1);
        m2 += delta * (x - mean);
    }
    return {mean, std::sqrt(m2 / n / n)};
}

}  // namespace raylex::test
