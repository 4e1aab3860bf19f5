// Transforms between two moments ("Physically Based Rendering", 4th edition, section 3.10.6, AnimatedTransform): each
// is taken apart into a translation, a rotation and a scale, which go their own ways. The rotation turns evenly about
// one axis, the shorter way round (quaternion slerp: Shoemake 1985, "Animating rotation with quaternion curves"); the
// others are linear.
#pragma once

#include "display/services/parameters.h"
#include "transport/math/transform.h"

namespace raylex::transport {

class AnimatedTransform {
  public:
    /// Errors at `where`: a transform that is not affine or cannot be inverted, or one of the two mirrors and the other
    /// does not, so that what moves would be flat in between.
    static Result<AnimatedTransform> between(const Transform& start, const Transform& end, const SourceLocation& where);

    /// At `x` in [0, 1]: `start` at 0, `end` at 1, to the bit. Outside of that, the nearer of them. What only
    /// translates keeps the rest of its matrix to the bit.
    [[nodiscard]] Transform at(double x) const;

  private:
    AnimatedTransform(const Transform& start, const Transform& end) : start_(start), end_(end) {}
    [[nodiscard]] Matrix4 linear_part_at(double x) const;

    Transform start_, end_;
    bool only_translates_ = false;
    Transform first_rotation_;
    std::array<Matrix4, 2> scales_{};      // symmetric; of mirroring transforms negative
    std::array<double, 3> axis_{1, 0, 0};  // unit, of the turn in the start's own frame
    double degrees_ = 0;                   // at most 180
};

}  // namespace raylex::transport
