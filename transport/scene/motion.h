// What moves in a scene, and what the shutter sees of it.
//
// Everything that moves is at its first transform until SceneDescription::transform_times[0], at its last from
// transform_times[1] on, and goes its way in between (math/animated_transform.h). The shutter is open from the camera's
// "shutteropen" to its "shutterclose" (0 and 1 by default), evenly sensitive. Ray::time counts what it sees of the way
// from 0 to 1, and nothing else of time is known to rendering.
#pragma once

#include <optional>

#include "transport/math/animated_transform.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Of the shutter's opening and closing, how much of their way things have gone: 0 none, 1 all. `open` and `close` are
/// the same two without bounds: a shutter that is open before or after the way is gone shows things standing there.
struct ShutterSpan {
    double first = 0, last = 1;
    double open = 0, close = 1;
    bool swapped = false;  ///< the camera's parameters name the later one first

    [[nodiscard]] bool moves() const { return first < last; }
    /// Ray::time of a share `u` of the shutter's time.
    [[nodiscard]] double time_of(double u) const;
    /// Of the way, at a ray's time.
    [[nodiscard]] double way(double time) const { return first + (last - first) * time; }
};

/// Errors: the camera's parameters, times that do not follow one another.
Result<ShutterSpan> shutter_span(const SceneDescription& scene);

/// Nothing for what stands still. Errors at the instance or the camera.
Result<std::optional<AnimatedTransform>> motion_of(const SceneDescription& scene, const SceneInstance& instance);
Result<std::optional<AnimatedTransform>> motion_of_camera(const SceneDescription& scene);

/// Whether any ray needs a time: something moves while the shutter is open.
bool is_moving(const SceneDescription& scene, const ShutterSpan& span);

/// Everything stands where it is halfway through the shutter's time, for good.
Status stop_motion(SceneDescription& scene);

}  // namespace raylex::transport
