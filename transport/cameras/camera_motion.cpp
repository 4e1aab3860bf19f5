#include "transport/cameras/camera_motion.h"

namespace raylex::transport {

CameraMotion::CameraMotion(const AnimatedTransform& motion, const ShutterSpan& shutter, const RenderSpace& space)
    : motion_(motion),
      shutter_(shutter),
      space_(space),
      world_to_first_(space.placed(motion.at(shutter.first)).inverse()) {}

Placement CameraMotion::at(Real time) const {
    Placement carry;
    carry.to_world =
        Matrix34((space_.placed(motion_.at(shutter_.way(static_cast<double>(time)))) * world_to_first_).matrix());
    carry.to_object = carry.to_world.inverse();
    return carry;
}

}  // namespace raylex::transport
