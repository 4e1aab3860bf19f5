#include "transport/lights/images/pixel_distribution.h"

#include <algorithm>

#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

/// The largest i with cumulative[i] <= u; `within` receives the position of u within that step.
std::size_t find_step(const Real* cumulative, std::size_t steps, Real u, Real& within) {
    const Real* upper = std::upper_bound(cumulative, cumulative + steps + 1, u);
    std::size_t i = upper == cumulative ? 0 : static_cast<std::size_t>(upper - cumulative) - 1;
    i = std::min(i, steps - 1);
    const Real width = cumulative[i + 1] - cumulative[i];
    within = width > 0 ? std::clamp((u - cumulative[i]) / width, Real(0), one_minus_epsilon) : 0.5f;
    return i;
}

}  // namespace

PixelDistribution::PixelDistribution(int width, int height, const std::vector<double>& weights)
    : width_(static_cast<std::size_t>(width)), height_(static_cast<std::size_t>(height)) {
    rows_.assign(height_ + 1, 0);
    columns_.assign(height_ * (width_ + 1), 0);
    std::vector<double> row_sums(height_);
    double total = 0;
    for (std::size_t y = 0; y < height_; ++y) {
        double sum = 0;
        for (std::size_t x = 0; x < width_; ++x) sum += weights[y * width_ + x];
        double running = 0;
        Real* row = columns_.data() + y * (width_ + 1);
        for (std::size_t x = 0; x < width_; ++x) {
            running += weights[y * width_ + x];
            row[x + 1] =
                sum > 0 ? static_cast<Real>(running / sum) : static_cast<Real>(x + 1) / static_cast<Real>(width_);
        }
        row[width_] = 1;
        row_sums[y] = sum;
        total += sum;
    }
    double running = 0;
    for (std::size_t y = 0; y < height_ && total > 0; ++y) {
        running += row_sums[y];
        rows_[y + 1] = static_cast<Real>(running / total);
    }
    if (total > 0) rows_[height_] = 1;
}

std::size_t PixelDistribution::pixel_of(const Vec2& at) const {
    const auto cell = [](Real v, std::size_t size) {
        return static_cast<std::size_t>(
            std::clamp(static_cast<int>(v * static_cast<Real>(size)), 0, static_cast<int>(size) - 1));
    };
    return cell(at.y, height_) * width_ + cell(at.x, width_);
}

Real PixelDistribution::density(std::size_t pixel) const {
    // Uses the stored cumulative shares, not the pixel's weight: they are what sample() uses.
    const std::size_t y = pixel / width_, x = pixel % width_;
    const Real* row = columns_.data() + y * (width_ + 1);
    const Real share = (rows_[y + 1] - rows_[y]) * (row[x + 1] - row[x]);
    return share * static_cast<Real>(width_) * static_cast<Real>(height_);
}

PixelDistribution::Drawn PixelDistribution::sample(const Vec2& u) const {
    if (rows_.empty() || !(rows_[height_] > 0)) return {};
    Real within_x, within_y;
    const std::size_t y = find_step(rows_.data(), height_, u.y, within_y);
    const std::size_t x = find_step(columns_.data() + y * (width_ + 1), width_, u.x, within_x);
    Drawn drawn;
    drawn.pixel = y * width_ + x;
    drawn.density = density(drawn.pixel);
    drawn.at = {(static_cast<Real>(x) + within_x) * (1 / static_cast<Real>(width_)),
                (static_cast<Real>(y) + within_y) * (1 / static_cast<Real>(height_))};
    return drawn;
}

}  // namespace raylex::transport
