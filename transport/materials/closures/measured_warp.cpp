#include <algorithm>
#include <cmath>

#include "transport/materials/closures/measured.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

namespace {

/// The integral from 0 to t of the line from a at 0 to b at 1, and t for a given integral, without cancellation.
Real linear_integral(Real t, Real a, Real b) {
    return t * (a + t * (b - a) / 2);
}
Real linear_inverse(Real integral, Real a, Real b) {
    const Real root = safe_sqrt(a * a + 2 * integral * (b - a));
    const Real t = a + root > 0 ? 2 * integral / (a + root) : 0;
    return std::clamp(t, Real(0), one_minus_epsilon);
}

}  // namespace

MeasuredWarp::MeasuredWarp(std::vector<float> values, std::size_t slices, std::size_t rows, std::size_t columns)
    : rows_(rows), columns_(columns), values_(std::move(values)) {
    conditional_.resize(values_.size());
    marginal_.resize(slices * rows);
    for (std::size_t s = 0; s < slices; ++s) {
        float* const slice = values_.data() + s * rows * columns;
        float* const along = conditional_.data() + s * rows * columns;
        float* const across = marginal_.data() + s * rows;
        for (int attempt = 0; attempt < 2; ++attempt) {
            double total = 0, last = 0;
            std::vector<double> sums(rows * columns);
            for (std::size_t y = 0; y < rows; ++y) {
                double sum = 0;
                for (std::size_t x = 0; x < columns; ++x) {
                    const std::size_t i = y * columns + x;
                    if (x > 0) sum += 0.5 * (double{slice[i - 1]} + double{slice[i]});
                    sums[i] = sum;
                }
                if (y > 0) total += 0.5 * (last + sum);
                last = sum;
                across[y] = static_cast<float>(total);
            }
            if (!(total > 0)) {  // nothing measured there
                std::fill_n(slice, rows * columns, 1.0f);
                continue;
            }
            for (std::size_t i = 0; i < sums.size(); ++i) {
                along[i] = static_cast<float>(sums[i] / total);
                slice[i] = static_cast<float>(double{slice[i]} / total);
            }
            for (std::size_t y = 0; y < rows; ++y) across[y] = static_cast<float>(double{across[y]} / total);
            break;
        }
    }
}

struct MeasuredWarp::Cell {
    std::size_t row, column;
    Real s, t;  // within: along the row, across rows
};

MeasuredWarp::Cell MeasuredWarp::cell(const Vec2& at) const {
    const Real x = std::clamp(at.x, Real(0), Real(1)) * static_cast<Real>(columns_ - 1),
               y = std::clamp(at.y, Real(0), Real(1)) * static_cast<Real>(rows_ - 1);
    const auto column = std::min(static_cast<std::size_t>(x), columns_ - 2),
               row = std::min(static_cast<std::size_t>(y), rows_ - 2);
    return {row, column, x - static_cast<Real>(column), y - static_cast<Real>(row)};
}

Real MeasuredWarp::mixed(const std::vector<float>& values, std::size_t per_slice, std::size_t index,
                         const MeasuredDirection& direction) const {
    Real sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
        if (direction.weight[k] > 0)
            sum += direction.weight[k] * static_cast<Real>(values[direction.slice[k] * per_slice + index]);
    return sum;
}

Real MeasuredWarp::row_sum(std::size_t row, const MeasuredDirection& direction) const {
    return mixed(conditional_, rows_ * columns_, row * columns_ + columns_ - 1, direction);
}

MeasuredWarp::Point MeasuredWarp::sample(Vec2 u, const MeasuredDirection& direction) const {
    const std::size_t area = rows_ * columns_;
    // Bisection for the last node whose sum is at most the wanted one.
    const auto find = [](std::size_t count, Real wanted, const auto& sum) {
        std::size_t low = 0, high = count - 1;
        while (low + 1 < high) {
            const std::size_t middle = (low + high) / 2;
            (sum(middle) <= wanted ? low : high) = middle;
        }
        return low;
    };
    const auto below = [&](std::size_t y) { return mixed(marginal_, rows_, y, direction); };
    const std::size_t row = find(rows_, u.y, below);
    const Real r0 = row_sum(row, direction), r1 = row_sum(row + 1, direction);
    const Real t = linear_inverse(std::max(u.y - below(row), Real(0)), r0, r1);
    const Real wanted = u.x * lerp(t, r0, r1);
    const auto left = [&](std::size_t x) {
        return lerp(t, mixed(conditional_, area, row * columns_ + x, direction),
                    mixed(conditional_, area, (row + 1) * columns_ + x, direction));
    };
    const std::size_t column = find(columns_, wanted, left);
    const auto node = [&](std::size_t x) {
        return lerp(t, mixed(values_, area, row * columns_ + x, direction),
                    mixed(values_, area, (row + 1) * columns_ + x, direction));
    };
    const Real c0 = node(column), c1 = node(column + 1);
    const Real s = linear_inverse(std::max(wanted - left(column), Real(0)), c0, c1);
    const Real wide = static_cast<Real>(columns_ - 1), high = static_cast<Real>(rows_ - 1);
    return {{(static_cast<Real>(column) + s) / wide, (static_cast<Real>(row) + t) / high},
            lerp(s, c0, c1) * wide * high};
}

MeasuredWarp::Point MeasuredWarp::invert(const Vec2& at, const MeasuredDirection& direction) const {
    const std::size_t area = rows_ * columns_;
    const Cell c = cell(at);
    const std::size_t i = c.row * columns_ + c.column;
    const auto across = [&](const std::vector<float>& values, std::size_t index) {
        return lerp(c.t, mixed(values, area, index, direction), mixed(values, area, index + columns_, direction));
    };
    const Real c0 = across(values_, i), c1 = across(values_, i + 1);
    const Real r0 = row_sum(c.row, direction), r1 = row_sum(c.row + 1, direction), whole = lerp(c.t, r0, r1);
    const Real x = across(conditional_, i) + linear_integral(c.s, c0, c1);
    const Real y = mixed(marginal_, rows_, c.row, direction) + linear_integral(c.t, r0, r1);
    const Real density = lerp(c.s, c0, c1) * static_cast<Real>(columns_ - 1) * static_cast<Real>(rows_ - 1);
    return {{whole > 0 ? std::clamp(x / whole, Real(0), Real(1)) : 0, std::clamp(y, Real(0), Real(1))}, density};
}

Real MeasuredWarp::density(const Vec2& at, const MeasuredDirection& direction) const {
    const std::size_t area = rows_ * columns_;
    const Cell c = cell(at);
    const std::size_t i = c.row * columns_ + c.column;
    const auto across = [&](std::size_t index) {
        return lerp(c.t, mixed(values_, area, index, direction), mixed(values_, area, index + columns_, direction));
    };
    return lerp(c.s, across(i), across(i + 1)) * static_cast<Real>(columns_ - 1) * static_cast<Real>(rows_ - 1);
}

}  // namespace raylex::transport
