// Where a moving instance is at a ray's time: linear between matrices that follow one another at even steps of time, as
// Embree has its motion, so that both speak of the same place at every time.
//
// Rotation is no linear motion. The steps are as many as it takes for no corner of the object's box to be further from
// where it should be than 1e-4 of the longest way that one of them goes: a corner that turns by an angle a in n steps
// is off by a / (8 n^2) of its way, so that half a turn takes 64, and 128 (Embree takes no more) are never needed.
#pragma once

#include <functional>
#include <vector>

#include "transport/geometry/render_space.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class InstanceMotion {
  public:
    static constexpr std::size_t most_steps = 128;
    /// Of what corners go, what the steps may leave them off by.
    static constexpr double tolerance = 1e-4;

    /// `placement` of a time from 0 to 1; `box` holds the object in its own space.
    InstanceMotion(const std::function<Transform(double)>& placement, const DBounds& box);

    /// One more than there are steps: from time 0 to time 1. Numbers are floats.
    [[nodiscard]] const std::vector<Matrix34>& keys() const { return keys_; }
    /// At a time from 0 to 1. The inverse is that of the interpolated matrix.
    [[nodiscard]] Placement at(Real time) const;
    /// How much more than that of a matrix at rest the rounding of Embree's own inverse may move a point: see the
    /// source.
    [[nodiscard]] static double rounding_growth(const Matrix34& to_world);

  private:
    std::vector<Matrix34> keys_;
};

}  // namespace raylex::transport
