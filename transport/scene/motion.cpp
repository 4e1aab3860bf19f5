#include "transport/scene/motion.h"

#include <algorithm>
#include <cmath>

#include "display/services/short_number.h"

namespace raylex::transport {

double ShutterSpan::time_of(double u) const {
    if (!moves()) return 0;
    return (std::clamp(open + (close - open) * u, 0.0, 1.0) - first) / (last - first);
}

Result<ShutterSpan> shutter_span(const SceneDescription& scene) {
    const ParameterSet& set = scene.camera.parameters;
    auto open = set.real_or("shutteropen", 0), close = set.real_or("shutterclose", 1);
    for (const auto* each : {&open, &close})
        if (!*each) return each->error();
    const auto [start, end] = scene.transform_times;
    if (!std::isfinite(*open) || !std::isfinite(*close))
        return error_at(scene.camera.location, "'shutteropen' and 'shutterclose' must be finite");
    if (!(start < end) || !std::isfinite(end - start))
        return error_at(scene.camera.location, "the transformation times are " + short_number(start, 6) + " and " +
                                                   short_number(end, 6) + "; expected the earlier one first");
    ShutterSpan span;
    span.swapped = *open > *close;
    span.open = (std::min(*open, *close) - start) / (end - start);
    span.close = (std::max(*open, *close) - start) / (end - start);
    span.first = std::clamp(span.open, 0.0, 1.0);
    span.last = std::clamp(span.close, 0.0, 1.0);
    return span;
}

Result<std::optional<AnimatedTransform>> motion_of(const SceneDescription& scene, const SceneInstance& instance) {
    if (instance.motion < 0) return std::optional<AnimatedTransform>();
    if (static_cast<std::size_t>(instance.motion) >= scene.moved_to.size())
        return error_at(instance.location, "the instance has no transform for the end of its motion");
    auto motion = AnimatedTransform::between(
        instance.to_world, scene.moved_to[static_cast<std::size_t>(instance.motion)], instance.location);
    if (!motion) return motion.error();
    return std::optional(*std::move(motion));
}

Result<std::optional<AnimatedTransform>> motion_of_camera(const SceneDescription& scene) {
    if (!scene.camera_moved_to) return std::optional<AnimatedTransform>();
    auto motion = AnimatedTransform::between(scene.camera_to_world, *scene.camera_moved_to, scene.camera.location);
    if (!motion) return motion.error();
    return std::optional(*std::move(motion));
}

bool is_moving(const SceneDescription& scene, const ShutterSpan& span) {
    return span.moves() && (scene.camera_moved_to.has_value() ||
                            std::any_of(scene.instances.begin(), scene.instances.end(),
                                        [](const SceneInstance& each) { return each.motion >= 0; }));
}

Status stop_motion(SceneDescription& scene) {
    const Result<ShutterSpan> span = shutter_span(scene);
    if (!span) return span.error();
    const double halfway = span->way(span->time_of(0.5)), now = span->moves() ? halfway : span->first;
    const auto camera = motion_of_camera(scene);
    if (!camera) return camera.error();
    if (*camera) scene.camera_to_world = (*camera)->at(now);
    scene.camera_moved_to.reset();
    for (SceneInstance& instance : scene.instances) {
        const auto motion = motion_of(scene, instance);
        if (!motion) return motion.error();
        if (*motion) instance.to_world = (*motion)->at(now);
        instance.motion = -1;
    }
    scene.moved_to.clear();
    return success();
}

}  // namespace raylex::transport
