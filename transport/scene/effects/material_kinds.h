// Classifies materials, shapes and lights for the analysis and removal of effects. Types of plugins belong to no class.
#pragma once

#include <algorithm>

#include "transport/color/spectrum.h"
#include "transport/scene/used_surfaces.h"

namespace raylex::transport {

[[nodiscard]] inline bool lets_light_through(const SceneEntity& material) {
    return material.type == "dielectric" || material.type == "thindielectric" || material.type == "raylex:sheet" ||
           material.type == "subsurface" || material.type == "diffusetransmission";
}
[[nodiscard]] inline bool is_subsurface(const SceneEntity& material) {
    return material.type == "subsurface";
}
[[nodiscard]] inline bool is_bump(const Parameter& parameter) {
    return parameter.name == "displacement" || parameter.name == "normalmap";
}
[[nodiscard]] inline bool has_bumps(const SceneEntity& material) {
    for (const Parameter& each : material.parameters.parameters)
        if (is_bump(each)) return true;
    return false;
}
[[nodiscard]] inline bool is_coated(const SceneEntity& material) {
    return material.type == "coateddiffuse" || material.type == "coatedconductor";
}
[[nodiscard]] inline bool asks_for_compensation(const SceneEntity& material) {
    for (const Parameter& each : material.parameters.parameters)
        if (each.name == "raylex:compensate") return each.booleans.size() == 1 && each.booleans.front() != 0;
    return false;
}
/// Whether a shape has cutouts. An interface is not a surface and has none; the interface part of a mix is passed like
/// a cutout. `mixed` is mixes_with_interface().
[[nodiscard]] inline bool has_cutouts(const SceneDescription& scene, const SceneShape& shape,
                                      const std::vector<std::uint8_t>& mixed) {
    const auto material = static_cast<std::size_t>(std::max(shape.material, 0));
    return !is_interface(scene, shape) &&
           (shape.alpha < 1 || !shape.alpha_texture.empty() || (material < mixed.size() && mixed[material] != 0));
}
/// Whether a medium is heterogeneous.
[[nodiscard]] inline bool is_grid(const SceneEntity& medium) {
    return medium.type == "uniformgrid" || medium.type == "rgbgrid" || medium.type == "cloud" ||
           medium.type == "nanovdb";
}
[[nodiscard]] inline bool is_light_at_point(const SceneEntity& light) {
    return light.type == "point" || light.type == "spot" || light.type == "goniometric" || light.type == "projection";
}
[[nodiscard]] inline bool is_delta_light(const SceneEntity& light) {
    return is_light_at_point(light) || light.type == "distant";
}
[[nodiscard]] inline bool is_environment(const SceneEntity& light) {
    return light.type == "infinite";
}

/// The parameter for a dielectric's index of refraction if it is a spectrum that varies; else null. Null also if it
/// cannot be read, which the build reports.
[[nodiscard]] inline const Parameter* varying_index(const SceneEntity& material) {
    if (material.type != "dielectric" && !is_subsurface(material)) return nullptr;
    for (const Parameter& each : material.parameters.parameters) {
        if (each.name != "eta") continue;
        const auto spectrum = varying_spectrum(each);
        return spectrum && *spectrum ? &each : nullptr;
    }
    return nullptr;
}

}  // namespace raylex::transport
