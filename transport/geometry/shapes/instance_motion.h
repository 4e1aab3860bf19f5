// The place of a moving instance at a ray's time: linear interpolation between matrices at equal steps of time. Embree
// interpolates in the same way, so both use the same place at every time.
//
// Rotation is not linear. There are as many steps as it takes to keep each corner of the object's box within 1e-4 of
// its right place, relative to the longest way of a corner. A corner that turns by an angle a in n steps is off by a /
// (8 n^2) of its way, so half a turn takes 64 steps, and 128, Embree's limit, are never needed.
#pragma once

#include <functional>
#include <vector>

#include "transport/geometry/render_space.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class InstanceMotion {
  public:
    static constexpr std::size_t most_steps = 128;
    /// The largest error of a corner, relative to the longest way of a corner.
    static constexpr double tolerance = 1e-4;

    /// `placement` gives the transform at a time from 0 to 1; `box` contains the object in its own space.
    InstanceMotion(const std::function<Transform(double)>& placement, const DBounds& box);

    /// The matrices from time 0 to time 1, one more than there are steps. Their numbers are floats.
    [[nodiscard]] const std::vector<Matrix34>& keys() const { return keys_; }
    /// The placement at a time from 0 to 1. Its inverse is that of the interpolated matrix.
    [[nodiscard]] Placement at(Real time) const;
    /// The factor by which the rounding of Embree's inverse may move a point further than for a matrix that does not
    /// move; derived in the source.
    [[nodiscard]] static double rounding_growth(const Matrix34& to_world);

  private:
    std::vector<Matrix34> keys_;
};

}  // namespace raylex::transport
