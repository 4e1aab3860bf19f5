// Scene-linear colour triples in the rendering space.
#pragma once

#include <algorithm>
#include <cmath>

namespace raylex {

template <class Real>
struct BasicRgb {
    Real r{}, g{}, b{};

    constexpr BasicRgb() = default;
    constexpr explicit BasicRgb(Real grey) : r(grey), g(grey), b(grey) {}
    constexpr BasicRgb(Real red, Real green, Real blue) : r(red), g(green), b(blue) {}
    template <class Other>
    constexpr explicit BasicRgb(const BasicRgb<Other>& o) : r(Real(o.r)), g(Real(o.g)), b(Real(o.b)) {}

    constexpr Real& operator[](int i) { return i == 0 ? r : i == 1 ? g : b; }
    constexpr const Real& operator[](int i) const { return i == 0 ? r : i == 1 ? g : b; }
    constexpr BasicRgb& operator+=(const BasicRgb& o) {
        r += o.r;
        g += o.g;
        b += o.b;
        return *this;
    }
    constexpr BasicRgb& operator*=(const BasicRgb& o) {
        r *= o.r;
        g *= o.g;
        b *= o.b;
        return *this;
    }
    constexpr BasicRgb& operator*=(Real s) {
        r *= s;
        g *= s;
        b *= s;
        return *this;
    }
    friend constexpr BasicRgb operator+(BasicRgb a, const BasicRgb& b) { return a += b; }
    friend constexpr BasicRgb operator-(const BasicRgb& a, const BasicRgb& b) {
        return {a.r - b.r, a.g - b.g, a.b - b.b};
    }
    friend constexpr BasicRgb operator*(BasicRgb a, const BasicRgb& b) { return a *= b; }
    friend constexpr BasicRgb operator*(BasicRgb a, Real s) { return a *= s; }
    friend constexpr BasicRgb operator*(Real s, BasicRgb a) { return a *= s; }
    friend constexpr BasicRgb operator/(const BasicRgb& a, Real s) { return a * (Real(1) / s); }
    friend constexpr BasicRgb operator/(const BasicRgb& a, const BasicRgb& b) {
        return {a.r / b.r, a.g / b.g, a.b / b.b};
    }
    constexpr bool operator==(const BasicRgb&) const = default;

    [[nodiscard]] constexpr bool is_black() const { return r == 0 && g == 0 && b == 0; }
    [[nodiscard]] constexpr Real max() const { return std::max(r, std::max(g, b)); }
    [[nodiscard]] constexpr Real average() const { return (r + g + b) / Real(3); }
};

using Rgb = BasicRgb<float>;    ///< radiance, throughput, albedo in transport
using RgbD = BasicRgb<double>;  ///< sums in the sample table and the frame buffer

template <class Real>
[[nodiscard]] inline bool is_finite(const BasicRgb<Real>& c) {
    return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

/// Relative luminance of linear sRGB / Rec. 709 primaries (IEC 61966-2-1).
template <class Real>
[[nodiscard]] constexpr Real luminance(const BasicRgb<Real>& c) {
    return Real(0.2126) * c.r + Real(0.7152) * c.g + Real(0.0722) * c.b;
}

}  // namespace raylex
