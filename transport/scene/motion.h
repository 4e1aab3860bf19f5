// The motion in a scene, and the part of it during which the shutter is open.
//
// Everything that moves is at its first transform until SceneDescription::transform_times[0], at its last from
// transform_times[1] on, and interpolated in between (math/animated_transform.h). The shutter is open from the camera's
// "shutteropen" to its "shutterclose" (0 and 1 by default), with constant sensitivity. Ray::time is 0 at the beginning
// and 1 at the end of the visible part of the motion; rendering uses no other time.
#pragma once

#include <optional>

#include "transport/math/animated_transform.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// `first` and `last` are the progress of the motion when the shutter opens and closes: 0 at its start, 1 at its end.
/// `open` and `close` are the same without clamping: a shutter that is open before or after the motion records objects
/// at rest.
struct ShutterSpan {
    double first = 0, last = 1;
    double open = 0, close = 1;
    bool swapped = false;  ///< the camera's parameters give the later time first

    [[nodiscard]] bool moves() const { return first < last; }
    /// Ray::time of the share `u` of the shutter interval.
    [[nodiscard]] double time_of(double u) const;
    /// The progress of the motion at a ray's time.
    [[nodiscard]] double way(double time) const { return first + (last - first) * time; }
};

/// Computes the span of a scene. Errors: the camera's parameters, times in the wrong order.
Result<ShutterSpan> shutter_span(const SceneDescription& scene);

/// The motion of an instance; nothing if it does not move. Errors name the instance or the camera.
Result<std::optional<AnimatedTransform>> motion_of(const SceneDescription& scene, const SceneInstance& instance);
Result<std::optional<AnimatedTransform>> motion_of_camera(const SceneDescription& scene);

/// Whether any ray needs a time: something moves while the shutter is open.
bool is_moving(const SceneDescription& scene, const ShutterSpan& span);

/// Fixes everything at its place in the middle of the shutter interval.
Status stop_motion(SceneDescription& scene);

}  // namespace raylex::transport
