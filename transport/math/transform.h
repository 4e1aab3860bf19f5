// Affine transforms with their inverse, in double, since scene files multiply many of them before a vertex is
// transformed.
#pragma once

#include <array>

#include "transport/math/vec.h"

namespace raylex::transport {

using Matrix4 = std::array<std::array<double, 4>, 4>;  ///< row-major; points are columns

[[nodiscard]] Matrix4 multiply(const Matrix4& a, const Matrix4& b);

class Transform {
  public:
    Transform();                                ///< identity
    explicit Transform(const Matrix4& matrix);  ///< computes the inverse; `invertible()` returns whether there is one
    Transform(const Matrix4& matrix, const Matrix4& inverse) : m_(matrix), inverse_(inverse) {}

    static Transform translate(double x, double y, double z);
    static Transform scale(double x, double y, double z);
    static Transform rotate(double degrees, double x, double y, double z);
    /// World to camera, left-handed, +z towards `look` (pbrt's LookAt). Not invertible if `up` and the view direction
    /// are parallel or null. A rotation about a null axis is not invertible either.
    static Transform look_at(const std::array<double, 3>& eye, const std::array<double, 3>& look,
                             const std::array<double, 3>& up);

    friend Transform operator*(const Transform& a, const Transform& b);  ///< b is applied first
    [[nodiscard]] Transform inverse() const;
    [[nodiscard]] const Matrix4& matrix() const { return m_; }
    [[nodiscard]] bool invertible() const { return invertible_; }
    [[nodiscard]] bool is_identity() const;
    [[nodiscard]] bool swaps_handedness() const;

    [[nodiscard]] Vec3 point(const Vec3& p) const;
    [[nodiscard]] BasicVec3<double> point_in_double(const BasicVec3<double>& p) const;
    [[nodiscard]] Vec3 vector(const Vec3& v) const;
    [[nodiscard]] Vec3 normal(const Vec3& n) const;  ///< by the inverse transpose; not normalised

  private:
    Matrix4 m_, inverse_;
    bool invertible_ = true;
};

}  // namespace raylex::transport
