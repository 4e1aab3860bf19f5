#include "transport/render/dark_lights.h"

#include <algorithm>
#include <limits>
#include <string>

namespace raylex::transport {
namespace {

/// Renders treat numbers below the smallest normal float as 0.
bool is_dark(const Light& light) {
    return !(light.power > 0) || light.emission.max() < std::numeric_limits<Real>::min();
}

bool any_medium_shines(const MediumTable& media) {
    for (std::size_t i = 0; i < media.size(); ++i)
        if (media[static_cast<std::int32_t>(i)].emits) return true;
    return false;
}

Error dark(const SourceLocation& location, const std::string& what) {
    return error_at(location, "this " + what + " light emits no light");
}

}  // namespace

std::vector<Error> find_dark_lights(const SceneDescription& scene, const LightTable& table, const MediumTable& media) {
    const std::span<const Light> lights = table.lights();
    if (lights.empty() && !any_medium_shines(media))
        return {error_at({scene.file, 0, 0}, "the scene has no light: its image is black")};
    std::vector<std::uint8_t> seen(scene.area_lights.size(), 0), shines(scene.area_lights.size(), 0);
    std::size_t primitives = 0;  // area lights come first
    for (; primitives < lights.size() && lights[primitives].is_area(); ++primitives) {
        const auto area = static_cast<std::size_t>(scene.shapes[lights[primitives].shape].area_light);
        seen[area] = 1;
        if (!is_dark(lights[primitives])) shines[area] = 1;
    }
    std::vector<Error> found;
    for (std::size_t i = 0; i < seen.size(); ++i)
        if (seen[i] != 0 && shines[i] == 0) found.push_back(dark(scene.area_lights[i].location, "area"));
    for (std::size_t i = 0; i < scene.lights.size() && primitives + i < lights.size(); ++i)
        if (is_dark(lights[primitives + i])) found.push_back(dark(scene.lights[i].location, scene.lights[i].type));
    return found;
}

}  // namespace raylex::transport
