// Shared code of sampling probes: random numbers, cells on the sphere, and a test of counts in cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

#include "display/services/split_mix.h"
#include "transport/math/sampling.h"

namespace raylex::experiments {

inline constexpr double exact_pi = std::numbers::pi;

/// A fixed sequence of numbers in [0, 1), so that a probe always gives the same result.
class Draws {
  public:
    explicit Draws(std::uint64_t seed) : state_(seed * raylex::golden_gamma + 1) {}
    std::uint64_t bits() { return raylex::mix_bits(state_ += raylex::golden_gamma); }
    transport::Real one() { return transport::unit_float(bits()); }
    transport::Vec2 two() {
        const transport::Real x = one();
        return {x, one()};
    }
    /// Returns a number with all 53 bits of a double.
    double fine() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  private:
    std::uint64_t state_;
};

/// The mean of samples and its standard error (Welford).
class RunningMean {
  public:
    void add(double x) {
        const double delta = x - mean_;
        mean_ += delta / ++count_;
        sum_of_squares_ += delta * (x - mean_);
    }
    [[nodiscard]] double mean() const { return mean_; }
    [[nodiscard]] double standard_error() const {
        return count_ > 1 ? std::sqrt(sum_of_squares_ / (count_ * (count_ - 1))) : 0;
    }

  private:
    double count_ = 0, mean_ = 0, sum_of_squares_ = 0;
};

/// Cells of the sphere around an axis. The rings are warped so that half of them lie in a lobe of width `scale`
/// (radians) around the axis: t = theta / (theta + scale), scaled to 1 at theta = pi.
class LobeCells {
  public:
    LobeCells(const transport::Vec3& axis, double scale, int rings, int sectors)
        : frame_(transport::Frame::from_normal(axis)), scale_(scale), rings_(rings), sectors_(sectors) {}

    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(rings_ * sectors_); }
    [[nodiscard]] std::size_t cell(const transport::Vec3& w) const {
        const transport::Vec3 l = frame_.to_local(w);
        const double theta = std::atan2(std::hypot(double(l.x), double(l.y)), double(l.z));
        const double t = theta / (theta + scale_) * (exact_pi + scale_) / exact_pi;
        double phi = std::atan2(double(l.y), double(l.x)) / (2 * exact_pi);
        if (phi < 0) phi += 1;
        const int ring = std::min(static_cast<int>(t * rings_), rings_ - 1);
        return static_cast<std::size_t>(ring * sectors_ + std::min(static_cast<int>(phi * sectors_), sectors_ - 1));
    }
    /// Integrates `density` over every cell by the midpoint rule with n x n points.
    template <class Density>
    [[nodiscard]] std::vector<double> integrate(const Density& density, int n) const {
        std::vector<double> result(size());
        const double top = exact_pi / (exact_pi + scale_);
        for (int i = 0; i < rings_ * n; ++i) {
            const double t = (i + 0.5) / (rings_ * n) * top, theta = scale_ * t / (1 - t);
            const double width = scale_ / ((1 - t) * (1 - t)) * top / (rings_ * n);
            const double area = std::sin(theta) * width * 2 * exact_pi / (sectors_ * n);
            for (int j = 0; j < sectors_ * n; ++j) {
                const double phi = 2 * exact_pi * (j + 0.5) / (sectors_ * n);
                const transport::Vec3 w =
                    frame_.to_world({static_cast<transport::Real>(std::sin(theta) * std::cos(phi)),
                                     static_cast<transport::Real>(std::sin(theta) * std::sin(phi)),
                                     static_cast<transport::Real>(std::cos(theta))});
                result[static_cast<std::size_t>(i / n * sectors_ + j / n)] += static_cast<double>(density(w)) * area;
            }
        }
        return result;
    }

  private:
    transport::Frame frame_;
    double scale_;
    int rings_, sectors_;
};

/// Returns by how many standard deviations Pearson's chi-squared of `observed` exceeds its mean for `expected` counts,
/// by Wilson and Hilferty's cube root (error below 0.02 for at least 10 cells). Cells that expect fewer than 10 are
/// pooled. Infinite if a cell has counts but expects none.
inline double chi_squared_deviation(const std::vector<double>& observed, const std::vector<double>& expected) {
    double chi2 = 0, pooled_observed = 0, pooled_expected = 0, cells = 0;
    const auto add = [&](double o, double e) {
        chi2 += (o - e) * (o - e) / e;
        cells += 1;
    };
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (expected[i] >= 10) {
            add(observed[i], expected[i]);
            continue;
        }
        pooled_observed += observed[i];
        pooled_expected += expected[i];
    }
    if (pooled_expected >= 10) add(pooled_observed, pooled_expected);
    else if (pooled_observed > 10 + 6 * std::sqrt(10.0)) return INFINITY;
    const double degrees = cells - 1;
    if (degrees < 1) return 0;
    return (std::cbrt(chi2 / degrees) - (1 - 2 / (9 * degrees))) / std::sqrt(2 / (9 * degrees));
}

}  // namespace raylex::experiments
