// Makes variants of a scene whose images have a known relation to its image.
#include <algorithm>

#include "experiments/invariants/scene_under_test.h"
#include "transport/scene/effects/material_kinds.h"
#include "transport/scene/typed_parameters.h"

namespace raylex::experiments {

using transport::SceneDescription;
using transport::SceneShape;
using transport::Transform;

namespace {

/// Multiplies a number of the set; a missing number counts as 1.
void multiply(ParameterSet& set, const std::string& name, double factor) {
    for (Parameter& parameter : set.parameters) {
        if (parameter.name != name || parameter.numbers.size() != 1) continue;
        parameter.numbers.front() *= factor;
        return;
    }
    set.parameters.push_back(transport::typed::real(name, factor));
}

/// Multiplies every number of a parameter. Returns false if the parameter is missing.
bool multiply_all(ParameterSet& set, const char* name, double factor) {
    for (Parameter& parameter : set.parameters) {
        if (parameter.name != name) continue;
        for (double& each : parameter.numbers) each *= factor;
        return true;
    }
    return false;
}

/// Multiplies the emission of a medium.
void brighten(transport::SceneMedium& medium, double factor) {
    ParameterSet& set = medium.parameters;
    if (multiply_all(set, "Lescale", factor) || multiply_all(set, "LeScale", factor)) return;
    if (medium.type != "uniformgrid") return multiply(set, "Lescale", factor);
    // The "Lescale" of a uniform grid is a grid that ends at the box, so a missing one is not a grid of ones.
    multiply_all(set, "Le", factor);
}

/// Transforms points, given as x y z of one point after another.
void move_points(std::vector<double>& numbers, const Transform& change) {
    for (std::size_t i = 0; i + 3 <= numbers.size(); i += 3) {
        const auto p = change.point_in_double({numbers[i], numbers[i + 1], numbers[i + 2]});
        numbers[i] = p.x;
        numbers[i + 1] = p.y;
        numbers[i + 2] = p.z;
    }
}

}  // namespace

SceneDescription moved(SceneDescription scene, const Transform& change) {
    scene.camera_to_world = change * scene.camera_to_world;
    for (SceneShape& shape : scene.shapes) shape.object_to_world = change * shape.object_to_world;
    for (transport::SceneInstance& instance : scene.instances) instance.to_world = change * instance.to_world;
    if (scene.camera_moved_to) *scene.camera_moved_to = change * *scene.camera_moved_to;
    for (transport::Transform& last : scene.moved_to) last = change * last;
    for (transport::SceneLight& light : scene.lights) {
        light.to_world = change * light.to_world;
        for (Parameter& parameter : light.parameters.parameters)
            if (parameter.name == "portal") move_points(parameter.numbers, change);  // portals are in world space
    }
    for (transport::SceneTexture& texture : scene.textures) texture.to_world = change * texture.to_world;
    for (transport::SceneMedium& medium : scene.media) medium.to_world = change * medium.to_world;
    return scene;
}

SceneDescription scaled(SceneDescription scene, double factor) {
    scene = moved(std::move(scene), Transform::scale(factor, factor, factor));
    for (transport::SceneLight& light : scene.lights)
        if (transport::is_light_at_point(light)) multiply(light.parameters, "scale", factor * factor);
    for (transport::SceneAreaLight& light : scene.area_lights) {
        const auto power = light.parameters.real_or("power", -1);  // of a surface that is now larger
        if (power && *power > 0) multiply(light.parameters, "scale", factor * factor);
    }
    for (transport::SceneEntity& medium : scene.media) multiply(medium.parameters, "scale", 1 / factor);
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        ParameterSet& set = scene.materials[i].parameters;
        const auto has = [&](const char* name) { return set.find(name) != nullptr; };
        // Scales the coefficients, or the mean free path if there is a reflectance.
        if (scene.materials[i].type == "subsurface")
            multiply(set, "scale",
                     has("reflectance") && !has("name") && !has("sigma_a") && !has("sigma_s") ? factor : 1 / factor);
        for (Parameter& parameter : set.parameters) {  // heights are lengths
            if (parameter.name != "displacement" || parameter.type != ParameterType::texture) continue;
            transport::SceneTexture higher;
            higher.type = "scale";
            higher.name = "raylex higher " + std::to_string(i);
            higher.location = parameter.location;
            higher.parameters.parameters = {transport::typed::texture("tex", parameter.strings.front()),
                                            transport::typed::real("scale", factor)};
            parameter.strings.front() = higher.name;
            scene.textures.push_back(std::move(higher));
        }
    }
    const auto factor_in_real = static_cast<transport::Real>(factor);
    for (SceneShape& shape : scene.shapes) shape.edge_length *= factor_in_real;  // of displaced meshes, in world space
    return scene;
}

bool can_be_brightened(const SceneDescription& scene) {
    return std::none_of(scene.media.begin(), scene.media.end(), [](const transport::SceneMedium& medium) {
        if (medium.type != "uniformgrid" || medium.parameters.find("Lescale") != nullptr) return false;
        const Parameter* le = medium.parameters.find("Le");
        return medium.parameters.find("temperature") != nullptr || (le != nullptr && le->type != ParameterType::rgb);
    });
}

SceneDescription brightened(SceneDescription scene, double factor) {
    for (transport::SceneLight& light : scene.lights) multiply(light.parameters, "scale", factor);
    for (transport::SceneAreaLight& light : scene.area_lights) multiply(light.parameters, "scale", factor);
    for (transport::SceneMedium& medium : scene.media) {
        const auto has = [&](const char* name) { return medium.parameters.find(name) != nullptr; };
        if (has("Le") || has("temperature") || medium.type == "nanovdb") brighten(medium, factor);
    }
    return scene;
}

SceneDescription textured(SceneDescription scene) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        for (Parameter& parameter : scene.materials[i].parameters.parameters) {
            const bool color = parameter.type == ParameterType::rgb && parameter.name == "reflectance";
            const bool number = parameter.type == ParameterType::real && parameter.name == "roughness";
            if (!color && !number) continue;
            transport::SceneTexture texture;
            texture.type = "constant";
            texture.name = "raylex constant " + std::to_string(i) + parameter.name;
            texture.spectrum = color;
            texture.location = parameter.location;
            Parameter value = parameter;
            value.name = "value";
            texture.parameters.parameters.push_back(std::move(value));
            parameter = transport::typed::texture(parameter.name, texture.name);
            scene.textures.push_back(std::move(texture));
        }
    return scene;
}

}  // namespace raylex::experiments
