// How a camera moves, whatever kind it is: a camera stands where it does when the shutter opens, and this carries what
// it sees from there to where it is at a time, and back.
#pragma once

#include "transport/geometry/render_space.h"
#include "transport/math/matrix34.h"
#include "transport/scene/motion.h"

namespace raylex::transport {

class CameraMotion {
  public:
    /// From the camera to the world in `motion`; to `space` here.
    CameraMotion(const AnimatedTransform& motion, const ShutterSpan& shutter, const RenderSpace& space);

    /// From where the camera stands when the shutter opens to where it is at `time`; the inverse beside it.
    [[nodiscard]] Placement at(Real time) const;

  private:
    AnimatedTransform motion_;
    ShutterSpan shutter_;
    RenderSpace space_;
    Transform world_to_first_;
};

}  // namespace raylex::transport
