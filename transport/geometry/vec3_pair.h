// Two vectors of doubles side by side, with the arithmetic of single ones, so that two hits are computed at a time.
#pragma once

#include "transport/math/matrix34.h"

namespace raylex::transport {

using DoublePair = double __attribute__((vector_size(16)));

struct DVec3Pair {
    DoublePair x, y, z;

    template <class Number>
    static DVec3Pair of(const BasicVec3<Number>& a, const BasicVec3<Number>& b) {
        return {DoublePair{a.x, b.x}, DoublePair{a.y, b.y}, DoublePair{a.z, b.z}};
    }
    [[nodiscard]] DVec3 operator[](int i) const { return {x[i], y[i], z[i]}; }
    friend DVec3Pair operator+(const DVec3Pair& a, const DVec3Pair& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend DVec3Pair operator-(const DVec3Pair& a, const DVec3Pair& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend DVec3Pair operator*(const DVec3Pair& a, const DoublePair& s) { return {a.x * s, a.y * s, a.z * s}; }
    friend DoublePair dot(const DVec3Pair& a, const DVec3Pair& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    friend DVec3Pair cross(const DVec3Pair& a, const DVec3Pair& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
};

}  // namespace raylex::transport
