// Three-component vectors. One type serves points, vectors and normals; which one a value is, its name says.
#pragma once

#include <cmath>

#include "display/services/rgb.h"

namespace raylex::transport {

struct Vec3 {
    float x = 0, y = 0, z = 0;

    constexpr float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr Vec3 operator-() const { return {-x, -y, -z}; }
    constexpr Vec3& operator+=(const Vec3& o) { x += o.x; y += o.y; z += o.z; return *this; }
    constexpr Vec3& operator*=(float s) { x *= s; y *= s; z *= s; return *this; }
    friend constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
    friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr Vec3 operator*(Vec3 a, float s) { return a *= s; }
    friend constexpr Vec3 operator*(float s, Vec3 a) { return a *= s; }
    friend constexpr Vec3 operator/(const Vec3& a, float s) { return a * (1.0f / s); }
    constexpr bool operator==(const Vec3&) const = default;
};

struct Vec2 {
    float x = 0, y = 0;
    constexpr bool operator==(const Vec2&) const = default;
};

constexpr float dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr float length_squared(const Vec3& v) { return dot(v, v); }
inline float length(const Vec3& v) { return std::sqrt(length_squared(v)); }
inline Vec3 normalize(const Vec3& v) { return v / length(v); }
inline float abs_dot(const Vec3& a, const Vec3& b) { return std::abs(dot(a, b)); }
constexpr Vec3 face_forward(const Vec3& n, const Vec3& v) { return dot(n, v) < 0 ? -n : n; }
inline bool is_finite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

inline constexpr float pi = 3.14159265358979323846f;
inline constexpr float inv_pi = 0.31830988618379067154f;

/// Orthonormal frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1)).
struct Frame {
    Vec3 s, t, n;

    static Frame from_normal(const Vec3& n) {
        const float sign = std::copysign(1.0f, n.z);
        const float a = -1.0f / (sign + n.z);
        const float b = n.x * n.y * a;
        return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
    }
    /// `tangent` is made orthogonal to `n`; falls back to from_normal when they are parallel.
    static Frame from_normal_and_tangent(const Vec3& n, const Vec3& tangent) {
        const Vec3 s = tangent - n * dot(n, tangent);
        const float l2 = length_squared(s);
        if (!(l2 > 1e-20f * length_squared(tangent)) || !(l2 > 0)) return from_normal(n);
        const Vec3 unit = s / std::sqrt(l2);
        return {unit, cross(n, unit), n};
    }
    [[nodiscard]] Vec3 to_local(const Vec3& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
    [[nodiscard]] Vec3 to_world(const Vec3& v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace raylex::transport
