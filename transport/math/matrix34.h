// Affine 3x4 maps in double, for quadrics and instances.
#pragma once

#include <array>
#include <cmath>

#include "transport/math/transform.h"

namespace raylex::transport {

struct DVec3 {
    double x = 0, y = 0, z = 0;
    DVec3() = default;
    constexpr DVec3(double a, double b, double c) : x(a), y(b), z(c) {}
    template <class T>
    constexpr explicit DVec3(const BasicVec3<T>& v) : x(v.x), y(v.y), z(v.z) {}
    friend constexpr DVec3 operator+(const DVec3& a, const DVec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr DVec3 operator-(const DVec3& a, const DVec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr DVec3 operator*(const DVec3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
    constexpr bool operator==(const DVec3&) const = default;
    [[nodiscard]] Vec3 to_real() const { return {static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)}; }
    // Friends are found for DVec3 arguments only: normalize({x, y, z}) keeps meaning a Vec3.
    friend constexpr double dot(const DVec3& a, const DVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    friend constexpr DVec3 cross(const DVec3& a, const DVec3& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    friend double length(const DVec3& v) { return std::sqrt(dot(v, v)); }
    friend DVec3 normalize(const DVec3& v) { return v * (1 / length(v)); }
};

struct Matrix34 {
    double m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

    Matrix34() = default;
    explicit Matrix34(const Matrix4& full) {
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 4; ++c) m[r][c] = full[r][c];
    }
    [[nodiscard]] Transform transform() const {
        Matrix4 full{};
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 4; ++c) full[r][c] = m[r][c];
        full[3][3] = 1;
        return Transform(full);
    }
    [[nodiscard]] DVec3 vector(const DVec3& v) const {
        return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
    }
    [[nodiscard]] DVec3 point(const DVec3& p) const { return vector(p) + DVec3{m[0][3], m[1][3], m[2][3]}; }
    /// Transforms a normal by the map whose inverse this is, with the transpose of this matrix. Not normalised.
    [[nodiscard]] DVec3 normal_of_inverse(const DVec3& n) const {
        return {m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z, m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
                m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z};
    }
    [[nodiscard]] double determinant() const {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    }
    /// The inverse by the adjoint; the matrix must be invertible.
    [[nodiscard]] Matrix34 inverse() const {
        const double scale = 1 / determinant();
        Matrix34 result;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) {
                const int a = (c + 1) % 3, b = (c + 2) % 3, d = (r + 1) % 3, e = (r + 2) % 3;
                result.m[r][c] = (m[a][d] * m[b][e] - m[a][e] * m[b][d]) * scale;
            }
        const DVec3 back = result.vector({m[0][3], m[1][3], m[2][3]});
        result.m[0][3] = -back.x, result.m[1][3] = -back.y, result.m[2][3] = -back.z;
        return result;
    }
};

/// The ratio of the solid angles around a unit direction d before and after a map M: |M d|^3 / |det M|.
inline double solid_angle_ratio(const Matrix34& map, const DVec3& d) {
    const double stretch = length(map.vector(d));
    return stretch * stretch * stretch / std::abs(map.determinant());
}

/// Whether the map's linear part is a rotation, mirrored or not, times `scale`, up to a relative error of `relative`.
inline bool keeps_angles(const Matrix34& map, double& scale, double relative) {
    const DVec3 x{map.m[0][0], map.m[1][0], map.m[2][0]}, y{map.m[0][1], map.m[1][1], map.m[2][1]},
        z{map.m[0][2], map.m[1][2], map.m[2][2]};
    scale = length(x);
    const double tolerance = relative * scale * scale;
    return std::abs(dot(x, y)) < tolerance && std::abs(dot(y, z)) < tolerance && std::abs(dot(z, x)) < tolerance &&
           std::abs(dot(y, y) - scale * scale) < tolerance && std::abs(dot(z, z) - scale * scale) < tolerance;
}

/// A transform with its inverse.
struct Placement {
    Matrix34 to_world, to_object;
    Placement() = default;
    explicit Placement(const Transform& t) : to_world(t.matrix()), to_object(t.inverse().matrix()) {}
};

}  // namespace raylex::transport
