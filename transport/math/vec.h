// Three-component vectors. One type serves points, vectors and normals; names distinguish them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/math/real.h"

namespace raylex::transport {

template <class T>
struct BasicVec3 {
    T x = 0, y = 0, z = 0;

    constexpr T operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr BasicVec3 operator-() const { return {-x, -y, -z}; }
    constexpr BasicVec3& operator+=(const BasicVec3& o) {
        x += o.x;
        y += o.y;
        z += o.z;
        return *this;
    }
    constexpr BasicVec3& operator*=(T s) {
        x *= s;
        y *= s;
        z *= s;
        return *this;
    }
    friend constexpr BasicVec3 operator+(BasicVec3 a, const BasicVec3& b) { return a += b; }
    friend constexpr BasicVec3 operator-(const BasicVec3& a, const BasicVec3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend constexpr BasicVec3 operator*(BasicVec3 a, T s) { return a *= s; }
    friend constexpr BasicVec3 operator*(T s, BasicVec3 a) { return a *= s; }
    friend constexpr BasicVec3 operator/(const BasicVec3& a, T s) { return a * (1 / s); }
    constexpr bool operator==(const BasicVec3&) const = default;
    constexpr operator BasicVec3<double>() const requires std::is_same_v<T, float> { return {x, y, z}; }
};

template <class T>
struct BasicVec2 {
    T x = 0, y = 0;
    constexpr bool operator==(const BasicVec2&) const = default;
    constexpr operator BasicVec2<double>() const requires std::is_same_v<T, float> { return {x, y}; }
};

using Vec3 = BasicVec3<Real>;
using Vec2 = BasicVec2<Real>;
/// The vector type of stored meshes, which Embree reads.
using StoredVec3 = BasicVec3<float>;
using StoredVec2 = BasicVec2<float>;

constexpr const StoredVec3& to_float(const StoredVec3& v) {
    return v;
}
constexpr const StoredVec2& to_float(const StoredVec2& v) {
    return v;
}
constexpr StoredVec3 to_float(const BasicVec3<double>& v) {
    return {to_float(v.x), to_float(v.y), to_float(v.z)};
}
constexpr StoredVec2 to_float(const BasicVec2<double>& v) {
    return {to_float(v.x), to_float(v.y)};
}

constexpr Real dot(const Vec3& a, const Vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr Real length_squared(const Vec3& v) {
    return dot(v, v);
}
inline Real length(const Vec3& v) {
    return std::sqrt(length_squared(v));
}
inline Vec3 normalize(const Vec3& v) {
    return v / length(v);
}
inline Real abs_dot(const Vec3& a, const Vec3& b) {
    return std::abs(dot(a, b));
}
constexpr Vec3 face_forward(const Vec3& n, const Vec3& v) {
    return dot(n, v) < 0 ? -n : n;
}
/// The absolute value of each coordinate. Signs are practically random, so a comparison would be a branch that is
/// mispredicted every other time.
inline Vec3 absolute(const Vec3& v) {
    return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}
constexpr Vec3 largest(const Vec3& a, const Vec3& b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
constexpr Vec3 smallest(const Vec3& a, const Vec3& b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
template <class T>
bool is_finite(const BasicVec3<T>& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline constexpr Real pi = std::numbers::pi_v<Real>;
inline constexpr Real inv_pi = std::numbers::inv_pi_v<Real>;

/// Orthonormal frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1)).
struct Frame {
    Vec3 s, t, n;

    static Frame from_normal(const Vec3& n) {
        const Real sign = std::copysign(1.0f, n.z);
        const Real a = -1.0f / (sign + n.z);
        const Real b = n.x * n.y * a;
        return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
    }
    /// Makes `tangent` orthogonal to `n`; falls back to from_normal() if they are parallel.
    static Frame from_normal_and_tangent(const Vec3& n, const Vec3& tangent) {
        const Vec3 s = tangent - n * dot(n, tangent);
        const Real l2 = length_squared(s);
        if (!(l2 > Real(1e-20) * length_squared(tangent)) || !(l2 > 0)) return from_normal(n);
        const Vec3 unit = s / std::sqrt(l2);
        return {unit, cross(n, unit), n};
    }
    [[nodiscard]] Vec3 to_local(const Vec3& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
    [[nodiscard]] Vec3 to_world(const Vec3& v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace raylex::transport
