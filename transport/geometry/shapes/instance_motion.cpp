#include "transport/geometry/shapes/instance_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raylex::transport {
namespace {

std::array<DVec3, 8> corners_of(const DBounds& box) {
    std::array<DVec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] = {i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                      i & 4 ? box.upper.z : box.lower.z};
    return corners;
}

Matrix34 mix(const Matrix34& a, const Matrix34& b, double x) {
    Matrix34 result;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) result.m[r][c] = (1 - x) * a.m[r][c] + x * b.m[r][c];
    return result;
}

Matrix34 rounded(const Transform& transform) {
    Matrix34 result(transform.matrix());
    for (auto& row : result.m)
        for (double& number : row) number = static_cast<float>(number);
    return result;
}

/// The matrices of `steps` steps, and the largest error of a corner in the middle of a step, over the longest way of
/// any.
std::vector<Matrix34> keys_of(const std::function<Transform(double)>& placement, const DBounds& box, std::size_t steps,
                              double& off) {
    const std::array<DVec3, 8> corners = corners_of(box);
    std::array<double, 8> ways{};
    std::vector<Matrix34> keys{rounded(placement(0))};
    off = 0;
    for (std::size_t k = 1; k <= steps; ++k) {
        const auto time = [&](double step) { return step / static_cast<double>(steps); };
        keys.push_back(rounded(placement(time(static_cast<double>(k)))));
        const Matrix34 middle(placement(time(static_cast<double>(k) - 0.5)).matrix()),
            mean = mix(keys[k - 1], keys[k], 0.5);
        for (std::size_t i = 0; i < 8; ++i) {
            ways[i] += length(keys[k].point(corners[i]) - keys[k - 1].point(corners[i]));
            off = std::max(off, length(middle.point(corners[i]) - mean.point(corners[i])));
        }
    }
    const double longest = *std::max_element(ways.begin(), ways.end());
    off = longest > 0 ? off / longest : 0;
    return keys;
}

}  // namespace

InstanceMotion::InstanceMotion(const std::function<Transform(double)>& placement, const DBounds& box) {
    for (std::size_t steps = 1; steps <= most_steps; steps *= 2) {
        double off = 0;
        keys_ = keys_of(placement, box, steps, off);
        if (box.empty() || off <= tolerance) return;
    }
}

Placement InstanceMotion::at(Real time) const {
    // In float, since Embree finds the step in float.
    const auto steps = static_cast<float>(keys_.size() - 1);
    const float scaled = to_float(time) * steps;
    const float step = std::clamp(std::floor(scaled), 0.0f, steps - 1);
    const auto k = static_cast<std::size_t>(step);
    Placement placement;
    placement.to_world = mix(keys_[k], keys_[k + 1], static_cast<double>(scaled - step));
    placement.to_object = placement.to_world.inverse();
    return placement;
}

// For every ray, Embree interpolates the two matrices (3 roundings an entry) and inverts the result in single
// precision, by its adjoint over its determinant. K is the sum of the magnitudes of the determinant's six products,
// over the determinant. The determinant's relative error is below gamma(8) K, and the error of an entry of the adjoint
// is below gamma(3). Interpolation adds as much again to both, and three more roundings make the entry: below gamma(24)
// K together, for entries about as large as the rows of the inverse. A point p, seen through a matrix with translation
// t, is |p| + |t| from the world's origin, twice what a row of the inverse gives for p alone. A matrix that does not
// move has gamma(6).
double InstanceMotion::rounding_growth(const Matrix34& to_world) {
    const auto& m = to_world.m;
    const auto minor = [&](int a, int b) { return std::abs(m[1][a] * m[2][b]) + std::abs(m[1][b] * m[2][a]); };
    const double products =
        std::abs(m[0][0]) * minor(1, 2) + std::abs(m[0][1]) * minor(0, 2) + std::abs(m[0][2]) * minor(0, 1);
    return 8 * products / std::abs(to_world.determinant());
}

}  // namespace raylex::transport
