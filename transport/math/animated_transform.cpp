#include "transport/math/animated_transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "display/services/elementary.h"

namespace raylex::transport {
namespace {

/// The rotation of a polar decomposition, by averaging with the inverse transpose (Higham 1986; Shoemake and Duff 1992,
/// "Matrix animation and polar decomposition"). A mirroring matrix is a rotation with a negative scale.
Matrix4 nearest_rotation(const Transform& transform) {
    Matrix4 q = transform.matrix();
    double square = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) square += q[i][j] * q[i][j];
    const double size = std::sqrt(square / 3) * (transform.swaps_handedness() ? -1 : 1);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) q[i][j] /= size;
        q[i][3] = 0;
    }
    for (int step = 0; step < 100; ++step) {
        const Matrix4 inverse = Transform(q).inverse().matrix();
        double change = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                const double mean = 0.5 * (q[i][j] + inverse[j][i]);
                change = std::max(change, std::abs(mean - q[i][j]));
                q[i][j] = mean;
            }
        if (!(change > 1e-15)) break;  // a few units in the last place: it has converged
    }
    return q;
}

Transform inverse_of_rotation(const Matrix4& r) {
    Matrix4 transposed{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) transposed[i][j] = r[j][i];
    return {transposed, r};
}

Matrix4 linear_part(Matrix4 m) {
    for (std::size_t i = 0; i < 3; ++i) m[i][3] = 0;
    return m;
}

/// The axis and angle of a rotation, by its quaternion (Shoemake 1985). The largest component is computed first, so
/// that no division is by a small number.
void axis_of(const Matrix4& r, std::array<double, 3>& axis, double& degrees) {
    const double w4 = 1 + r[0][0] + r[1][1] + r[2][2], x4 = 1 + r[0][0] - r[1][1] - r[2][2],
                 y4 = 1 - r[0][0] + r[1][1] - r[2][2], z4 = 1 - r[0][0] - r[1][1] + r[2][2];
    const double most = std::max({w4, x4, y4, z4});
    std::array<double, 4> q{};  // w, x, y, z
    if (most == w4) q = {w4, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
    else if (most == x4) q = {r[2][1] - r[1][2], x4, r[0][1] + r[1][0], r[0][2] + r[2][0]};
    else if (most == y4) q = {r[0][2] - r[2][0], r[0][1] + r[1][0], y4, r[1][2] + r[2][1]};
    else q = {r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], z4};
    const double sine = std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    degrees = 0;
    axis = {1, 0, 0};
    if (!(sine > 0)) return;
    const double side = q[0] < 0 ? -1 : 1;  // the shorter way
    axis = {side * q[1] / sine, side * q[2] / sine, side * q[3] / sine};
    degrees = elementary::atan2(sine, std::abs(q[0])) * 360 / std::numbers::pi;
}

}  // namespace

Result<AnimatedTransform> AnimatedTransform::between(const Transform& start, const Transform& end,
                                                     const SourceLocation& where) {
    const std::array<double, 4> last{0, 0, 0, 1};
    for (const Transform* each : {&start, &end})
        if (!each->invertible() || each->matrix()[3] != last)
            return error_at(where,
                            "a moving transformation must be affine and have an inverse at the start and the end");
    if (start.swaps_handedness() != end.swaps_handedness())
        return error_at(where,
                        "only one of the transformations at the start and the end mirrors, so the moving object would "
                        "be flat in between");
    AnimatedTransform result(start, end);
    result.only_translates_ = linear_part(start.matrix()) == linear_part(end.matrix());
    const Matrix4 first = nearest_rotation(start), second = nearest_rotation(end);
    const Transform back = inverse_of_rotation(first);
    result.first_rotation_ = back.inverse();
    result.scales_ = {(back * Transform(linear_part(start.matrix()))).matrix(),
                      (inverse_of_rotation(second) * Transform(linear_part(end.matrix()))).matrix()};
    axis_of((back * Transform(second)).matrix(), result.axis_, result.degrees_);
    return result;
}

Matrix4 AnimatedTransform::linear_part_at(double x) const {
    Matrix4 scale{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) scale[i][j] = (1 - x) * scales_[0][i][j] + x * scales_[1][i][j];
    scale[3][3] = 1;
    const Transform turned = first_rotation_ * Transform::rotate(x * degrees_, axis_[0], axis_[1], axis_[2]);
    return (turned * Transform(scale)).matrix();
}

Transform AnimatedTransform::at(double x) const {
    if (!(x > 0)) return start_;
    if (!(x < 1)) return end_;
    Matrix4 m = only_translates_ ? start_.matrix() : linear_part_at(x);
    for (std::size_t i = 0; i < 3; ++i) m[i][3] = (1 - x) * start_.matrix()[i][3] + x * end_.matrix()[i][3];
    return Transform(m);
}

}  // namespace raylex::transport
