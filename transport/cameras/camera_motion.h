// Motion of a camera of any kind. A camera stands where it is when the shutter opens; this class carries rays from
// there to the camera's place at a time, and points back.
#pragma once

#include "transport/geometry/render_space.h"
#include "transport/math/matrix34.h"
#include "transport/scene/motion.h"

namespace raylex::transport {

class CameraMotion {
  public:
    /// `motion` is the transform from the camera to the world; results are in `space`.
    CameraMotion(const AnimatedTransform& motion, const ShutterSpan& shutter, const RenderSpace& space);

    /// The placement that carries points from the camera's place at shutter opening to its place at `time`, with the
    /// inverse.
    [[nodiscard]] Placement at(Real time) const;

  private:
    AnimatedTransform motion_;
    ShutterSpan shutter_;
    RenderSpace space_;
    Transform world_to_first_;
};

}  // namespace raylex::transport
