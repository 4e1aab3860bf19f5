// The regression of a tile's filter, and the estimate of its risk.
#include <algorithm>
#include <array>
#include <cmath>

#include "display/output/denoise/tile_filter.h"

namespace raylex::display {

namespace {

constexpr std::size_t most_terms = 16;

/// Slopes along features, and along positions in units of the radius, are reduced as if these had this noise.
constexpr double ridge = 1e-2;

/// Squared errors below this part of a squared value count as small.
constexpr float relative_floor = 1e-2f;

/// The square of the light that a window may lose, relative to the variance of its sum.
constexpr float most_loss = 1;

/// Solves A x = (1, 0, ...) for a symmetric positive definite matrix, given as its lower triangle row by row, by
/// Cholesky's method. Directions without weight get 0.
void solve_first(std::array<double, most_terms*(most_terms + 1) / 2>& a, std::size_t n,
                 std::array<double, most_terms>& x) {
    const auto at = [&](std::size_t i, std::size_t j) -> double& { return a[i * (i + 1) / 2 + j]; };
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = at(i, j);
            for (std::size_t k = 0; k < j; ++k) sum -= at(i, k) * at(j, k);
            if (i == j) at(i, i) = sum > 1e-12 ? std::sqrt(sum) : 0;
            else at(i, j) = at(j, j) > 0 ? sum / at(j, j) : 0;
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        double sum = i == 0 ? 1 : 0;
        for (std::size_t k = 0; k < i; ++k) sum -= at(i, k) * x[k];
        x[i] = at(i, i) > 0 ? sum / at(i, i) : 0;
    }
    for (std::size_t i = n; i-- > 0;) {
        double sum = x[i];
        for (std::size_t k = i + 1; k < n; ++k) sum -= at(k, i) * x[k];
        x[i] = at(i, i) > 0 ? sum / at(i, i) : 0;
    }
}

}  // namespace

/// Terms: 1, the features, x and y, all as differences from the pixel.
void TileFilter::regress_row(int y) {
    constexpr int margin = search_radius + patch_radius;
    const std::size_t width = static_cast<std::size_t>(width_), area = width * static_cast<std::size_t>(height_);
    const std::size_t terms = features_.size() + 3, row = static_cast<std::size_t>(y) * width;
    const std::size_t at = static_cast<std::size_t>((y + margin) * stride_ + margin);
    std::fill(moments_.begin(), moments_.end(), 0.0f);
    const auto differences_at = [&](std::size_t k) {
        const int dx = static_cast<int>(k) % search_side - search_radius,
                  dy = static_cast<int>(k) / search_side - search_radius;
        for (std::size_t f = 0; f < features_.size(); ++f) {
            const float *p = &features_[f][at], *q = p + dy * stride_ + dx;
            float* to = &differences_[f * width];
            for (std::size_t x = 0; x < width; ++x) to[x] = q[x] - p[x];
        }
        std::fill_n(&differences_[(terms - 3) * width], width, static_cast<float>(dx) / search_radius);
        std::fill_n(&differences_[(terms - 2) * width], width, static_cast<float>(dy) / search_radius);
    };
    float* const product = &differences_[terms * width];
    for (std::size_t k = 0; k < searched; ++k) {
        const float* weights = &weights_[k * area + row];
        differences_at(k);
        float* to = moments_.data();
        for (std::size_t i = 0; i < terms; ++i) {
            if (i == 0) std::copy_n(weights, width, product);
            else
                for (std::size_t x = 0; x < width; ++x) product[x] = weights[x] * differences_[(i - 1) * width + x];
            for (std::size_t x = 0; x < width; ++x) to[x] += product[x];
            to += width;
            for (std::size_t j = 1; j <= i; ++j, to += width) {
                const float* other = &differences_[(j - 1) * width];
                for (std::size_t x = 0; x < width; ++x) to[x] += product[x] * other[x];
            }
        }
    }
    std::vector<float> coefficients(terms * width);
    for (std::size_t x = 0; x < width; ++x) {
        std::array<double, most_terms*(most_terms + 1) / 2> matrix{};
        for (std::size_t i = 0; i < terms * (terms + 1) / 2; ++i)
            matrix[i] = static_cast<double>(moments_[i * width + x]);
        const double total = matrix[0];
        for (std::size_t i = 1; i < terms; ++i) {
            const double noise = i <= features_.size() ? static_cast<double>(feature_noise_[i - 1][at + x]) : 0.0;
            matrix[i * (i + 1) / 2 + i] += total * (noise + ridge);
        }
        std::array<double, most_terms> solution{};
        solve_first(matrix, terms, solution);
        for (std::size_t i = 0; i < terms; ++i) coefficients[i * width + x] = static_cast<float>(solution[i]);
    }
    for (std::size_t k = 0; k < searched; ++k) {
        float* weights = &weights_[k * area + row];
        differences_at(k);
        std::copy_n(coefficients.data(), width, product);
        for (std::size_t i = 1; i < terms; ++i)
            for (std::size_t x = 0; x < width; ++x)
                product[x] += coefficients[i * width + x] * differences_[(i - 1) * width + x];
        for (std::size_t x = 0; x < width; ++x) weights[x] *= product[x];
    }
}

/// Turns weights into those of the value at the pixel of a linear function of features and position, fitted to the
/// neighbourhood by weighted least squares.
void TileFilter::regress() {
    for (int y = 0; y < height_; ++y) regress_row(y);
}

/// Sums over windows of the risk radius, for the pixels of the tile.
std::vector<float> TileFilter::summed(const std::vector<float>& estimated) const {
    const int width = kept_.width(), height = kept_.height();
    std::vector<float> rows(static_cast<std::size_t>(width * height_)),
        result(static_cast<std::size_t>(width * height));
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width; ++x)
            for (int k = 0; k <= 2 * risk_radius; ++k)
                rows[static_cast<std::size_t>(y * width + x)] +=
                    estimated[static_cast<std::size_t>(y * width_ + x + k)];
    for (int y = 0; y < height; ++y)
        for (int k = 0; k <= 2 * risk_radius; ++k)
            for (int x = 0; x < width; ++x)
                result[static_cast<std::size_t>(y * width + x)] += rows[static_cast<std::size_t>((y + k) * width + x)];
    return result;
}

TileEstimate TileFilter::noisy(std::size_t layer) const {
    const LayerPlanes& planes = layers_[layer];
    TileEstimate result;
    constexpr int margin = risk_radius + search_radius + patch_radius;
    for (int y = 0; y < kept_.height(); ++y)
        for (int x = 0; x < kept_.width(); ++x) {
            const auto i = static_cast<std::size_t>((y + margin) * stride_ + x + margin);
            for (std::size_t c = 0; c < 3; ++c) result.values[c].push_back(planes.values[c][i]);
            result.risk.push_back(planes.variance[0][i] + planes.variance[1][i] + planes.variance[2][i]);
        }
    result.shown.assign(result.risk.size(), 1);
    return result;
}

/// The weighted sums of three planes, for all pixels of estimated_. The weights of a row stay in the cache.
std::array<std::vector<float>, 3> TileFilter::apply(const std::array<std::vector<float>, 3>& planes) const {
    constexpr int margin = search_radius + patch_radius;
    const std::size_t area = static_cast<std::size_t>(width_ * height_);
    std::array<std::vector<float>, 3> result;
    for (std::vector<float>& plane : result) plane.resize(area);
    for (int y = 0; y < height_; ++y)
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < searched; ++k) {
                const int dx = static_cast<int>(k) % search_side - search_radius,
                          dy = static_cast<int>(k) / search_side - search_radius;
                const float* from = &planes[c][static_cast<std::size_t>((y + margin + dy) * stride_ + margin + dx)];
                const std::size_t row = static_cast<std::size_t>(y * width_);
                const float* weights = &weights_[k * area + row];
                float* to = &result[c][row];
                for (int x = 0; x < width_; ++x) to[x] += weights[x] * from[x];
            }
    return result;
}

/// With the filter y = W u of pixels u of variance v, the step t has the risk t^2 |y - u|^2 + v - 2 t (v - W_ii v).
/// The removed noise y - u has at least the variance (1 - W_ii)^2 v. If it is smaller, v is too large.
/// A window that loses more light than noise explains is a highlight, and takes a shorter step.
TileEstimate TileFilter::estimate(std::size_t layer, const TileEstimate* guide) const {
    const LayerPlanes& planes = layers_[layer];
    const std::size_t area = static_cast<std::size_t>(width_ * height_);
    constexpr int margin = search_radius + patch_radius;
    const std::array<std::vector<float>, 3> filtered = apply(planes.values);
    std::array<std::vector<float>, 3> lost;
    for (std::vector<float>& plane : lost) plane.resize(area);
    // Risks are averaged relative to each pixel's noise and value: otherwise the brightest pixel decides for its
    // window.
    std::vector<float> change(area), noise(area), kept(area), removed(area), counted(area), scale(area), total(area);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const auto i = static_cast<std::size_t>(y * width_ + x),
                       at = static_cast<std::size_t>((y + margin) * stride_ + margin + x);
            if (inside_[at] == 0) continue;
            counted[i] = 1;
            float square = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                lost[c][i] = planes.values[c][at] - filtered[c][i];
                change[i] += lost[c][i] * lost[c][i];
                total[i] += planes.variance[c][at];
                square += planes.values[c][at] * planes.values[c][at] + filtered[c][i] * filtered[c][i];
            }
            scale[i] = total[i] + relative_floor * square + 1e-30f;
            change[i] /= scale[i];
            noise[i] = total[i] / scale[i];
            const float self = std::min(1.0f, weights_[searched / 2 * area + i]);
            kept[i] = noise[i] * self;
            removed[i] = noise[i] * (1 - self) * (1 - self);
        }
    const std::vector<float> counts = summed(counted), totals = summed(total);
    for (std::vector<float>* plane : {&change, &noise, &kept, &removed, &lost[0], &lost[1], &lost[2]})
        *plane = summed(*plane);
    TileEstimate result = noisy(layer);
    for (int y = 0; y < kept_.height(); ++y)
        for (int x = 0; x < kept_.width(); ++x) {
            const auto i = static_cast<std::size_t>(y * kept_.width() + x),
                       j = static_cast<std::size_t>((y + risk_radius) * width_ + x + risk_radius);
            const float changed = change[i] / counts[i], before = noise[i] / counts[i], self = kept[i] / counts[i];
            const float gain = std::max(0.0f, before - self);
            float t = changed > gain ? gain / changed : 1.0f, loss = 0;
            for (const std::vector<float>& plane : lost) loss += std::max(0.0f, plane[i]) * std::max(0.0f, plane[i]);
            if (t * t * loss > most_loss * totals[i]) t = std::sqrt(most_loss * totals[i] / loss);
            if (guide != nullptr) t = guide->step[i];
            result.step.push_back(t);
            if (change[i] < removed[i]) result.shown[i] = change[i] / removed[i];
            for (std::size_t c = 0; c < 3; ++c) result.values[c][i] += t * (filtered[c][j] - result.values[c][i]);
            result.risk[i] = scale[j] * std::max(self, t * t * changed + before - 2 * t * gain);
        }
    return result;
}

}  // namespace raylex::display
