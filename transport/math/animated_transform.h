// Interpolation of transforms between two moments ("Physically Based Rendering", 4th edition, section 3.10.6,
// AnimatedTransform): each transform is split into a translation, a rotation and a scale, which are interpolated
// separately. The rotation turns evenly about one axis, the shorter way round (quaternion slerp: Shoemake 1985,
// "Animating rotation with quaternion curves"); the others are linear.
#pragma once

#include "display/services/parameters.h"
#include "transport/math/transform.h"

namespace raylex::transport {

class AnimatedTransform {
  public:
    /// Errors at `where`: a transform that is not affine or cannot be inverted, or only one of the two mirrors, so that
    /// the moving object would be flat in between.
    static Result<AnimatedTransform> between(const Transform& start, const Transform& end, const SourceLocation& where);

    /// The transform at `x` in [0, 1]: exactly `start` at 0 and `end` at 1. Outside of [0, 1], the nearer of them. If
    /// only the translation changes, the rest of the matrix is exact.
    [[nodiscard]] Transform at(double x) const;

  private:
    AnimatedTransform(const Transform& start, const Transform& end) : start_(start), end_(end) {}
    [[nodiscard]] Matrix4 linear_part_at(double x) const;

    Transform start_, end_;
    bool only_translates_ = false;
    Transform first_rotation_;
    std::array<Matrix4, 2> scales_{};      // symmetric; negative for mirroring transforms
    std::array<double, 3> axis_{1, 0, 0};  // unit axis of the rotation in the start's own frame
    double degrees_ = 0;                   // at most 180
};

}  // namespace raylex::transport
