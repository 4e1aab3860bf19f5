#include "display/buffer/adaptive/error_forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "display/services/elementary.h"

namespace raylex::display {

std::vector<PixelMoments> pixel_moments(std::span<const double> values, std::span<const double> variances,
                                        std::size_t components) {
    std::vector<PixelMoments> pixels(values.size() / components);
    for (std::size_t pixel = 0; pixel < pixels.size(); ++pixel) {
        double mean = 0, variance = 0;
        for (std::size_t c = 0; c < components; ++c) {
            mean += std::abs(values[pixel * components + c]);
            variance += variances[pixel * components + c];
        }
        pixels[pixel] = {mean / static_cast<double>(components), variance / static_cast<double>(components), 0};
    }
    return pixels;
}

double darkest(std::span<const PixelMoments> pixels, double floor) {
    double mean = 0;
    for (const PixelMoments& pixel : pixels) mean += pixel.mean;
    mean /= static_cast<double>(pixels.size());
    return mean == 0 ? std::numeric_limits<double>::infinity() : floor * mean;
}

namespace {

// Guards against division by 0: a black pixel without a floor has a relative error as large as its deviation permits.
double reference(double mean, double darkest) {
    return std::max({mean, darkest, 1e-30});
}

}  // namespace

double relative_error(const PixelMoments& pixel, double darkest, double weight) {
    return weight * std::sqrt(pixel.variance_of_mean) / reference(pixel.mean, darkest);
}

std::optional<double> crossing(const ErrorPoint& from, const ErrorPoint& to, double square) {
    if (!(from.samples > 0) || from.square <= square || to.square > square) return std::nullopt;
    if (to.square <= 0) return to.samples;
    const double part = elementary::log(from.square / square) / elementary::log(from.square / to.square);
    return from.samples * elementary::pow(to.samples / from.samples, part);
}

void PooledErrors::Sums::add(const Sums& other) {
    pixels += other.pixels;
    n += other.n;
    nm += other.nm;
    nmm += other.nmm;
    nv += other.nv;
    nn += other.nn;
    nnv += other.nnv;
    nnvv += other.nnvv;
}

PooledErrors::PooledErrors(std::span<const PixelMoments> pixels, int width, int height, double darkest)
    : width_(width), height_(height), darkest_(darkest), scatter_(pixels.size()) {
    sums_.reserve(pixels.size());
    squares_.reserve(pixels.size());
    for (const PixelMoments& pixel : pixels) {
        const double n = pixel.samples, m = pixel.mean, v = n * pixel.variance_of_mean;
        sums_.push_back({1, n, n * m, n * m * m, n * v, n * n, n * n * v, n * n * v * v});
        const double error = relative_error(pixel, darkest);
        squares_.push_back(n * error * error);
    }
}

bool PooledErrors::grow() {
    if (edge_ == largest_edge) return false;
    const int smaller = edge_, columns = (width_ + smaller - 1) / smaller, rows = (height_ + smaller - 1) / smaller;
    edge_ *= 2;
    std::vector<Sums> larger(static_cast<std::size_t>((columns + 1) / 2) * static_cast<std::size_t>((rows + 1) / 2));
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            larger[pool(x * smaller, y * smaller)].add(
                sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)]);
    sums_ = std::move(larger);
    for (int y0 = 0; y0 < height_; y0 += edge_)
        for (int x0 = 0; x0 < width_; x0 += edge_) {
            const Sums& sums = sums_[pool(x0, y0)];
            if (sums.pixels < 2 || sums.n == 0) continue;
            const double m = sums.nm / sums.n, v = sums.nv / sums.n;
            const double between = (sums.nmm - m * sums.nm) / (sums.pixels - 1);
            if (between > most_between * v) continue;
            const double deviation = v / (reference(m, darkest_) * reference(m, darkest_));
            const double around = std::max(0.0, sums.nnvv - v * (2 * sums.nnv - v * sums.nn));  // sum n^2 (v_i - v)^2
            const double scatter = v > 0 ? std::sqrt(around * sums.pixels / (sums.pixels - 1)) / (sums.n * v) : 0.0;
            for (int y = y0; y < std::min(y0 + edge_, height_); ++y)
                for (int x = x0; x < std::min(x0 + edge_, width_); ++x) {
                    const std::size_t pixel =
                        static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
                    squares_[pixel] = deviation;
                    scatter_[pixel] = scatter;
                }
        }
    return true;
}

double PooledErrors::samples(int x, int y) const {
    return sums_[pool(x, y)].n;
}

void PartsOfSum::add(double part) {
    ++count_;
    sum_ += part;
    squares_ += part * part;
}

double PartsOfSum::standard_error() const {
    if (count_ < 2) return sum_;
    return std::sqrt(std::max(0.0, count_ * squares_ - sum_ * sum_) / (count_ - 1));
}

double PartsOfSum::lower() const {
    return sum_ > 0 ? sum_ * elementary::exp(-standard_error() / sum_) : 0;
}

void add_parts(std::span<const double> pixels, int width, int height, PartsOfSum& parts) {
    constexpr int edge = PooledErrors::largest_edge;
    for (int y0 = 0; y0 < height; y0 += edge)
        for (int x0 = 0; x0 < width; x0 += edge) {
            double part = 0;
            for (int y = y0; y < std::min(y0 + edge, height); ++y) {
                const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
                for (int x = x0; x < std::min(x0 + edge, width); ++x) part += pixels[row + static_cast<std::size_t>(x)];
            }
            parts.add(part);
        }
}

void ErrorForecast::add_level(const PooledErrors& pools) {
    std::size_t level = 0;
    while (1 << level < pools.edge()) ++level;
    add_parts(pools.squares(), pools.width(), pools.height(), squares_[level]);
    if (level == levels - 1)
        for (std::size_t pixel = 0; pixel < pools.squares().size(); ++pixel)
            scatter_ += pools.squares()[pixel] * pools.scatter()[pixel];
    if (level > 0) return;
    for (int y = 0; y < pools.height(); ++y)
        for (int x = 0; x < pools.width(); ++x) samples_ += pools.samples(x, y);
    pixels_ += static_cast<double>(pools.squares().size());
}

void ErrorForecast::add(PooledErrors pools) {
    do add_level(pools);
    while (pools.grow());
}

bool ErrorForecast::few_samples_decide() const {
    // For k equal samples the scatter is 1 / sqrt(k) of the variance.
    return scatter_ > 0.5 * squares_.back().sum();
}

std::array<ErrorPoint, ErrorForecast::levels> ErrorForecast::path(bool least) const {
    std::array<ErrorPoint, levels> points;
    for (std::size_t level = 0; level < levels; ++level) {
        const double square = least && level > 0 ? squares_[level].lower() : squares_[level].sum();
        const double samples = samples_ / pixels_ * static_cast<double>(1 << (2 * level));
        points[level] = {samples, weight_ * weight_ * square / (pixels_ * samples)};
    }
    return points;
}

Forecast ErrorForecast::samples_to(double error) const {
    const double square = error * error;
    std::size_t decides = 0;
    const auto along = [&](const std::array<ErrorPoint, levels>& points) {
        if (points[0].square <= square) return points[0].samples;
        for (decides = 1; decides < levels; ++decides)
            if (const auto samples = crossing(points[decides - 1], points[decides], square)) return *samples;
        decides = levels - 1;
        return samples_to_error(points.back().samples, std::sqrt(points.back().square), error);
    };
    Forecast forecast{along(path(false)), 0};
    if (decides > 0 && (squares_[decides].few_decide() || few_samples_decide()))
        forecast.least = std::min(along(path(true)), forecast.expected);
    return forecast;
}

double ErrorForecast::error_after(double samples) const {
    const auto points = path(false);
    std::size_t at = 0;
    while (at + 1 < levels && points[at + 1].samples <= samples) ++at;
    const ErrorPoint& from = points[at];
    double slope = -1;  // slope of the logarithm of the square if E is constant
    if (samples > from.samples && at + 1 < levels && from.square > 0 && points[at + 1].square > 0)
        slope = elementary::log(points[at + 1].square / from.square) /
                elementary::log(points[at + 1].samples / from.samples);
    return std::sqrt(from.square * elementary::pow(samples / from.samples, slope));
}

}  // namespace raylex::display
