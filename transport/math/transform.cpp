#include "transport/math/transform.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "display/services/elementary.h"

namespace raylex::transport {

namespace {

using Double3 = std::array<double, 3>;

constexpr Matrix4 identity_matrix() {
    return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
}

Matrix4 transpose(const Matrix4& m) {
    Matrix4 t{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) t[i][j] = m[j][i];
    return t;
}

/// Gauss-Jordan elimination with row pivoting; false when no pivot is left.
bool invert(Matrix4 m, Matrix4& inverse) {
    inverse = identity_matrix();
    for (std::size_t column = 0; column < 4; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column + 1; row < 4; ++row)
            if (std::abs(m[row][column]) > std::abs(m[pivot][column])) pivot = row;
        const double value = m[pivot][column];
        if (!(std::abs(value) > 0) || !std::isfinite(value)) {
            inverse = identity_matrix();
            return false;
        }
        std::swap(m[pivot], m[column]);
        std::swap(inverse[pivot], inverse[column]);
        for (std::size_t k = 0; k < 4; ++k) {
            m[column][k] /= value;
            inverse[column][k] /= value;
        }
        for (std::size_t row = 0; row < 4; ++row) {
            const double factor = m[row][column];
            if (row == column || factor == 0) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                m[row][k] -= factor * m[column][k];
                inverse[row][k] -= factor * inverse[column][k];
            }
        }
    }
    for (const auto& row : inverse)
        for (const double value : row)
            if (!std::isfinite(value)) {
                inverse = identity_matrix();
                return false;
            }
    return true;
}

Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double norm(const Double3& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

Double3 unit(const Double3& v) {
    const double length = norm(v);
    return {v[0] / length, v[1] / length, v[2] / length};
}

Vec3 narrow(double x, double y, double z) {
    return {static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)};
}

}  // namespace

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 product{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + a[i][3] * b[3][j];
    return product;
}

Transform::Transform() : m_(identity_matrix()), inverse_(identity_matrix()) {}

Transform::Transform(const Matrix4& matrix) : m_(matrix), inverse_(identity_matrix()) {
    invertible_ = invert(matrix, inverse_);
}

Transform Transform::translate(double x, double y, double z) {
    return {{{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}}},
            {{{1, 0, 0, -x}, {0, 1, 0, -y}, {0, 0, 1, -z}, {0, 0, 0, 1}}}};
}

Transform Transform::scale(double x, double y, double z) {
    return Transform(Matrix4{{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}, {0, 0, 0, 1}}});
}

// Rodrigues' rotation formula in matrix form; the inverse of a rotation is its transpose. A null axis has no inverse.
Transform Transform::rotate(double degrees, double x, double y, double z) {
    const Double3 axis{x, y, z};
    if (!(norm(axis) > 0) || !std::isfinite(norm(axis)) || !std::isfinite(degrees)) return Transform(Matrix4{});
    const Double3 a = unit(axis);
    const double radians = degrees * std::numbers::pi / 180;
    // Multiples of 90 degrees are common in scene files and should not carry the rounding of pi.
    const double quarter = std::remainder(degrees, 90.0) == 0 ? std::remainder(degrees / 90, 4.0) : 0.5;
    auto [sine, cosine] = elementary::sin_cos(radians);
    if (quarter == std::floor(quarter)) {
        sine = std::abs(quarter) == 1 ? quarter : 0;
        cosine = quarter == 0 ? 1 : std::abs(quarter) == 2 ? -1 : 0;
    }
    const double versine = 1 - cosine;
    const Matrix4 m{
        {{a[0] * a[0] * versine + cosine, a[0] * a[1] * versine - a[2] * sine, a[0] * a[2] * versine + a[1] * sine, 0},
         {a[0] * a[1] * versine + a[2] * sine, a[1] * a[1] * versine + cosine, a[1] * a[2] * versine - a[0] * sine, 0},
         {a[0] * a[2] * versine - a[1] * sine, a[1] * a[2] * versine + a[0] * sine, a[2] * a[2] * versine + cosine, 0},
         {0, 0, 0, 1}}};
    return {m, transpose(m)};
}

Transform Transform::look_at(const std::array<double, 3>& eye, const std::array<double, 3>& look,
                             const std::array<double, 3>& up) {
    const Double3 forward{look[0] - eye[0], look[1] - eye[1], look[2] - eye[2]};
    if (!(norm(forward) > 0) || !(norm(up) > 0)) return Transform(Matrix4{});
    const Double3 direction = unit(forward);
    const Double3 sideways = cross(unit(up), direction);  // left-handed: up x forward is the camera's +x
    if (!(norm(sideways) > 1e-12)) return Transform(Matrix4{});
    const Double3 right = unit(sideways);
    const Double3 true_up = cross(direction, right);
    const Matrix4 world_from_camera{{{right[0], true_up[0], direction[0], eye[0]},
                                     {right[1], true_up[1], direction[1], eye[1]},
                                     {right[2], true_up[2], direction[2], eye[2]},
                                     {0, 0, 0, 1}}};
    return Transform(world_from_camera).inverse();
}

Transform operator*(const Transform& a, const Transform& b) {
    Transform product(multiply(a.m_, b.m_), multiply(b.inverse_, a.inverse_));
    product.invertible_ = a.invertible_ && b.invertible_;
    return product;
}

Transform Transform::inverse() const {
    Transform inverted(inverse_, m_);
    inverted.invertible_ = invertible_;
    return inverted;
}

bool Transform::is_identity() const {
    return m_ == identity_matrix();
}

bool Transform::swaps_handedness() const {
    const double determinant = m_[0][0] * (m_[1][1] * m_[2][2] - m_[1][2] * m_[2][1]) -
                               m_[0][1] * (m_[1][0] * m_[2][2] - m_[1][2] * m_[2][0]) +
                               m_[0][2] * (m_[1][0] * m_[2][1] - m_[1][1] * m_[2][0]);
    return determinant < 0;
}

Vec3 Transform::point(const Vec3& p) const {
    const BasicVec3<double> moved = point_in_double(p);
    return narrow(moved.x, moved.y, moved.z);
}

BasicVec3<double> Transform::point_in_double(const BasicVec3<double>& p) const {
    const auto& [x, y, z] = p;
    const double px = m_[0][0] * x + m_[0][1] * y + m_[0][2] * z + m_[0][3];
    const double py = m_[1][0] * x + m_[1][1] * y + m_[1][2] * z + m_[1][3];
    const double pz = m_[2][0] * x + m_[2][1] * y + m_[2][2] * z + m_[2][3];
    const double w = m_[3][0] * x + m_[3][1] * y + m_[3][2] * z + m_[3][3];
    if (w == 1) return {px, py, pz};
    return {px / w, py / w, pz / w};
}

Vec3 Transform::vector(const Vec3& v) const {
    const double x = v.x, y = v.y, z = v.z;
    return narrow(m_[0][0] * x + m_[0][1] * y + m_[0][2] * z, m_[1][0] * x + m_[1][1] * y + m_[1][2] * z,
                  m_[2][0] * x + m_[2][1] * y + m_[2][2] * z);
}

Vec3 Transform::normal(const Vec3& n) const {
    const double x = n.x, y = n.y, z = n.z;
    return narrow(inverse_[0][0] * x + inverse_[1][0] * y + inverse_[2][0] * z,
                  inverse_[0][1] * x + inverse_[1][1] * y + inverse_[2][1] * z,
                  inverse_[0][2] * x + inverse_[1][2] * y + inverse_[2][2] * z);
}

}  // namespace raylex::transport
