// Predicts errors for more samples than the image has.
//
// For a pixel with a known value, E = n e^2, the squared relative error times the number of samples, is the same for
// all n. But the value comes from the same samples. Where light is rare and bright, most pixels have not sampled it and
// look converged; in a pixel with a single bright sample, that sample is the value, and the error is 1 however bright
// the sample. E then grows with n until all pixels have their share: in fog with a lamp, tenfold from 16 to 4096
// samples.
//
// The final value can be predicted: k pixels with the same expected value act as one pixel with k times the samples. So
// E is also measured in pools of 2 x 2, 4 x 4 and 8 x 8 pixels. For a pool with N samples, mean m and mean variance v
// of one sample (both averaged over the components), a pixel of N samples has
//
//     e^2 = E / N,  E = v / max(m, d)^2,  d: darkest value (AdaptiveSettings::floor times the image's mean).
//
// A test decides whether the pixels of a pool have the same expected value. One-way analysis of variance (Fisher,
// Statistical Methods for Research Workers, 1925) compares the mean square between pixels, sum n_i (m_i - m)^2 / (k -
// 1), with that within pixels, v. If the values agree, both have the same expectation, even when a single bright sample
// dominates both. If the first exceeds `most_between` times v, the pixels keep the E of the smaller pools.
//
// Between two sizes of pools errors go by a power of the samples; beyond the largest, E stays. tests/experiments/study/
// tests/experiments/study/prediction_test.cpp measures the accuracy; experiments/docs/stopping.md states it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raylex::display {

/// One channel of one pixel: mean of |value| over the components, mean of the variances of their means, and samples.
struct PixelMoments {
    double mean = 0, variance_of_mean = 0, samples = 0;
};

/// The moments from `values` and the variances of their means, interleaved by component. `samples` is left at 0.
std::vector<PixelMoments> pixel_moments(std::span<const double> values, std::span<const double> variances,
                                        std::size_t components);
/// The value d above: `floor` times the mean over these pixels; infinity when the mean is 0, so that black images have
/// no error.
[[nodiscard]] double darkest(std::span<const PixelMoments> pixels, double floor);
/// The error e above, times `weight`.
[[nodiscard]] double relative_error(const PixelMoments& pixel, double darkest, double weight = 1);

/// The number of samples with error `target`, if `samples` have `error` and the error falls with their square root.
[[nodiscard]] inline double samples_to_error(double samples, double error, double target) {
    const double ratio = error / target;
    return samples * ratio * ratio;
}

/// The squared error after a number of samples.
struct ErrorPoint {
    double samples = 0, square = 0;
};
/// The point where the power law through two points reaches `square`; none if it is not between them.
[[nodiscard]] std::optional<double> crossing(const ErrorPoint& from, const ErrorPoint& to, double square);

/// A rectangle of pixels, pooled in squares of increasing size.
class PooledErrors {
  public:
    static constexpr int largest_edge = 8;
    static constexpr double most_between = 2;

    /// `pixels` are in row order.
    PooledErrors(std::span<const PixelMoments> pixels, int width, int height, double darkest);

    /// Doubles the edge of the pools; false when they have the largest edge. Pools at the right and bottom can be
    /// smaller.
    bool grow();
    [[nodiscard]] int edge() const { return edge_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    /// [pixel] E of its pool.
    [[nodiscard]] std::span<const double> squares() const { return squares_; }
    /// [pixel] Relative standard deviation of E, from the scatter of the variances of the pool's pixels; 0 before
    /// grow().
    [[nodiscard]] std::span<const double> scatter() const { return scatter_; }
    /// The number of samples N of the pool that contains the pixel.
    [[nodiscard]] double samples(int x, int y) const;

  private:
    /// Sums over the pixels of a pool; n, m and v as above.
    struct Sums {
        double pixels = 0, n = 0, nm = 0, nmm = 0, nv = 0, nn = 0, nnv = 0, nnvv = 0;
        void add(const Sums& other);
    };
    [[nodiscard]] std::size_t pool(int x, int y) const {
        return static_cast<std::size_t>(y / edge_) * static_cast<std::size_t>((width_ + edge_ - 1) / edge_) +
               static_cast<std::size_t>(x / edge_);
    }
    int width_, height_, edge_ = 1;
    double darkest_;
    std::vector<Sums> sums_;                 // [pool]
    std::vector<double> squares_, scatter_;  // [pixel]
};

/// A predicted number of samples. If the prediction is uncertain because few parts of the image or few samples dominate
/// it, `least` is the prediction from PartsOfSum::lower(); otherwise 0.
struct Forecast {
    double expected = 0, least = 0;
};

/// The standard error of a sum over pixels, from the scatter of its parts, squares of PooledErrors::largest_edge
/// pixels. Real differences between parts count as noise, so it is an upper bound.
class PartsOfSum {
  public:
    /// Adds the part of one square.
    void add(double part);
    [[nodiscard]] double sum() const { return sum_; }
    [[nodiscard]] double standard_error() const;
    /// Above a sixth, a quarter is less than 1.5 standard errors, and the sum is too uncertain to be shown as "about".
    [[nodiscard]] bool few_decide() const { return standard_error() > sum_ / 6; }
    /// The sum reduced by one standard error on a logarithmic scale.
    [[nodiscard]] double lower() const;

  private:
    double count_ = 0, sum_ = 0, squares_ = 0;
};
/// Adds the squares of a rectangle of pixels in row order.
void add_parts(std::span<const double> pixels, int width, int height, PartsOfSum& parts);

/// Predicts the error of an image, the root of the mean square over its pixels, for equal numbers of samples per pixel.
class ErrorForecast {
  public:
    /// Predicts errors times `weight`.
    explicit ErrorForecast(double weight = 1) : weight_(weight) {}
    /// Adds a part of the image; pools it up to the largest size.
    void add(PooledErrors pools);
    /// Adds one level from the current size of the pools.
    void add_level(const PooledErrors& pools);

    [[nodiscard]] bool empty() const { return pixels_ == 0; }
    /// Returns whether variances in the largest pools scatter as if at most four samples dominated them. Then other
    /// samples of equal brightness are likely to exist that no pixel has found (Good, Biometrika 40, 1953: the unseen
    /// mass is about what was seen once).
    [[nodiscard]] bool few_samples_decide() const;
    /// The mean number of samples per pixel with this error; at least the current number.
    [[nodiscard]] Forecast samples_to(double error) const;
    [[nodiscard]] double error_after(double samples) const;

  private:
    static constexpr std::size_t levels = 4;
    static_assert(1 << (levels - 1) == PooledErrors::largest_edge);
    /// The levels as points; `least`: from the lower bounds of the pools.
    [[nodiscard]] std::array<ErrorPoint, levels> path(bool least) const;
    double weight_, pixels_ = 0, samples_ = 0;
    double scatter_ = 0;  // of the largest pools, weighted by their squares
    std::array<PartsOfSum, levels> squares_;
};

}  // namespace raylex::display
