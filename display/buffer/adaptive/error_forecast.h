// What errors come to with more samples than there are.
//
// Of a pixel whose value is known, E = n e^2, the square of its relative error times its samples, is the same for all
// n. But values come from the same samples. Where light is rare and bright most pixels have met none and look finished,
// and to one that has met a single such sample that sample is its brightness: its error is 1, however bright the
// sample. E then grows with n until all pixels have their share; in fog with a lamp, tenfold from 16 to 4096 samples.
//
// What it grows to can be seen beforehand: k pixels that look at the same thing are one pixel with k times the samples.
// So E is measured again in pools of 2 x 2, 4 x 4 and 8 x 8 pixels. With N samples in a pool, their mean m and the mean
// variance v of one sample (both averaged over the components), a pixel of N samples has
//
//     e^2 = E / N,  E = v / max(m, d)^2,  d: how dark a pixel may be (AdaptiveSettings::floor times the image's mean).
//
// Do the pixels of a pool look at the same thing? One-way analysis of variance (Fisher, Statistical Methods for
// Research Workers, 1925) compares the mean square between them, sum n_i (m_i - m)^2 / (k - 1), with that within them,
// v. If they do, both have one expectation, also when a single bright sample makes up both. Above `most_between` times
// v they do not, and the pixels keep the E of the smaller pools.
//
// Between two sizes of pools errors go by a power of the samples; beyond the largest, E stays. tests/experiments/study/
// prediction_test.cpp measures how far off that is; experiments/docs/stopping.md has the figures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raylex::display {

/// One channel of one pixel: the mean of its components' |value|, that of the variances of their means, its samples.
struct PixelMoments {
    double mean = 0, variance_of_mean = 0, samples = 0;
};

/// `values` and the variances of their means, component by component. `samples` are left at 0.
std::vector<PixelMoments> pixel_moments(std::span<const double> values, std::span<const double> variances,
                                        std::size_t components);
/// d above: `floor` times the mean over these pixels; infinity when that mean is 0, so that black images have no error.
[[nodiscard]] double darkest(std::span<const PixelMoments> pixels, double floor);
/// e above, times `weight`.
[[nodiscard]] double relative_error(const PixelMoments& pixel, double darkest, double weight = 1);

/// How many samples have the error `target`, when so many have `error` and errors fall with the root of the samples.
[[nodiscard]] inline double samples_to_error(double samples, double error, double target) {
    const double ratio = error / target;
    return samples * ratio * ratio;
}

/// The square of an error after so many samples.
struct ErrorPoint {
    double samples = 0, square = 0;
};
/// Where the power law through two points comes down to `square`; none when that is not between them.
[[nodiscard]] std::optional<double> crossing(const ErrorPoint& from, const ErrorPoint& to, double square);

/// A rectangle of pixels, pooled by larger and larger squares.
class PooledErrors {
  public:
    static constexpr int largest_edge = 8;
    static constexpr double most_between = 2;

    /// `pixels` row by row.
    PooledErrors(std::span<const PixelMoments> pixels, int width, int height, double darkest);

    /// Pools of twice the edge; false when they are the largest. Pools at the right and at the bottom may be cut off.
    bool grow();
    [[nodiscard]] int edge() const { return edge_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    /// [pixel] E of its pool.
    [[nodiscard]] std::span<const double> squares() const { return squares_; }
    /// [pixel] Standard deviation of E relative to it, as the variances of the pool's pixels scatter; 0 before grow().
    [[nodiscard]] std::span<const double> scatter() const { return scatter_; }
    /// N of the pool that a pixel lies in.
    [[nodiscard]] double samples(int x, int y) const;

  private:
    /// Over the pixels of a pool; n, m and v as above.
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

/// A number of samples. Where little is known of it, since few parts of the image or few samples decide, `least` is
/// what it is if the parts count PartsOfSum::lower(); else 0.
struct Forecast {
    double expected = 0, least = 0;
};

/// The standard error of a sum over pixels, as the parts of squares of PooledErrors::largest_edge scatter. That counts
/// what parts of the image differ by as chance, so it is at least the standard error.
class PartsOfSum {
  public:
    /// One square's part.
    void add(double part);
    [[nodiscard]] double sum() const { return sum_; }
    [[nodiscard]] double standard_error() const;
    /// Above a sixth, a quarter is less than 1.5 standard errors: too little to say "about".
    [[nodiscard]] bool few_decide() const { return standard_error() > sum_ / 6; }
    /// Less one standard error, on the scale of logarithms.
    [[nodiscard]] double lower() const;

  private:
    double count_ = 0, sum_ = 0, squares_ = 0;
};
/// Adds those of a rectangle of pixels, row by row.
void add_parts(std::span<const double> pixels, int width, int height, PartsOfSum& parts);

/// How the error of an image, the root of the mean square over its pixels, goes on when all pixels get as many samples.
class ErrorForecast {
  public:
    /// Of errors times `weight`.
    explicit ErrorForecast(double weight = 1) : weight_(weight) {}
    /// A part of the image, and how it is when pooled.
    void add(PooledErrors pools);
    /// As pooled now; then the same for larger pools.
    void add_level(const PooledErrors& pools);

    [[nodiscard]] bool empty() const { return pixels_ == 0; }
    /// In the largest pools, variances scatter as where four samples or fewer make up a pool's. Then there are likely
    /// others, as bright, that none has met (Good, Biometrika 40, 1953: as much is unseen as was seen once).
    [[nodiscard]] bool few_samples_decide() const;
    /// Samples of a pixel, in the mean. No fewer than there are.
    [[nodiscard]] Forecast samples_to(double error) const;
    [[nodiscard]] double error_after(double samples) const;

  private:
    static constexpr std::size_t levels = 4;
    static_assert(1 << (levels - 1) == PooledErrors::largest_edge);
    /// By what pools say at least, when `least`.
    [[nodiscard]] std::array<ErrorPoint, levels> path(bool least) const;
    double weight_, pixels_ = 0, samples_ = 0;
    double scatter_ = 0;  // of the largest pools, each counting as much as its square
    std::array<PartsOfSum, levels> squares_;
};

}  // namespace raylex::display
