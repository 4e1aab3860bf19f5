#include "transport/scene/scene_hash.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

#include "display/services/hash64.h"

namespace raylex::transport {
namespace {

/// A hash of all added values, which depends on their order.
class SceneHash {
  public:
    template <class Number>
    requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
    void add(Number number) { bytes({reinterpret_cast<const char*>(&number), sizeof number}); }
    void add(const std::string& text) { bytes(text); }
    template <class Item>
    void add(const std::vector<Item>& items) {
        if constexpr (std::is_arithmetic_v<Item> || std::is_same_v<Item, StoredVec3> ||
                      std::is_same_v<Item, StoredVec2>) {
            bytes({reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item)});
        } else {
            add(items.size());
            for (const Item& item : items) add(item);
        }
    }
    void add(const std::optional<bool>& flag) { add(flag ? 1 + static_cast<int>(*flag) : 0); }
    void add(const Transform& transform) {
        for (const auto& row : transform.matrix())
            for (const double number : row) add(number);
    }

    // If this binding stops compiling, the struct has a member that is not hashed yet.
    void add(const Parameter& parameter) {
        const auto& [name, type, numbers, strings, booleans, location, used] = parameter;
        static_cast<void>(location), static_cast<void>(used);
        add(name);
        add(type);
        add(numbers);
        add(booleans);
        for (const std::string& text : strings) {
            std::error_code failed;
            if (text.starts_with('/') && std::filesystem::is_regular_file(text, failed)) add_file(text);
            else add(text);
        }
    }
    void add(const SceneEntity& entity) {
        const auto& [name, type, parameters, location] = entity;
        static_cast<void>(location);
        add(name);
        add(type);
        add(parameters.parameters);
    }
    void add(const SceneTexture& texture) {
        add(static_cast<const SceneEntity&>(texture));
        add(texture.spectrum);
        add(texture.to_world);
    }
    void add(const SceneMedium& medium) {
        add(static_cast<const SceneEntity&>(medium));
        add(medium.to_world);
    }
    void add(const SceneLight& light) {
        add(static_cast<const SceneEntity&>(light));
        add(light.to_world);
        add(light.group);
    }
    void add(const SceneAreaLight& light) {
        add(static_cast<const SceneEntity&>(light));
        add(light.group);
    }
    void add(const SceneShape& shape) {
        const auto& [kind, source_file, location, positions, normals, uvs, indices, curve_type, curve_widths,
                     displacement_texture, edge_length, radius, z_min, z_max, phi_max, height, inner_radius,
                     object_to_world, flip_normal, material, area_light, inside_medium, outside_medium, alpha,
                     alpha_texture, label, labelled, holdout] = shape;
        static_cast<void>(location);
        add(kind);
        add(source_file);  // the name of an asset in cryptomattes
        add(positions);
        add(normals);
        add(uvs);
        add(indices);
        add(curve_type);
        add(curve_widths);
        add(displacement_texture);
        add(edge_length);
        for (const Real number : {radius, z_min, z_max, phi_max, height, inner_radius}) add(number);
        add(object_to_world);
        add(flip_normal);
        add(material);
        add(area_light);
        add(inside_medium);
        add(outside_medium);
        add(alpha);
        add(alpha_texture);
        add(label);
        if (labelled) add(labelled);  // cryptomattes use it
        add(holdout);
    }
    void add(const SceneObject& object) {
        const auto& [name, shapes] = object;
        add(name);
        add(shapes);
    }
    void add(const SceneInstance& instance) {
        const auto& [object, to_world, label, holdout, location, motion] = instance;
        static_cast<void>(location);
        add(object);
        add(to_world);
        add(label);
        add(holdout);
        if (motion >= 0) add(motion);
    }

    [[nodiscard]] std::uint64_t value() const { return value_; }

  private:
    void bytes(std::string_view content) { value_ = hash64(content, value_); }
    void add_file(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        bytes(std::string{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()});
    }
    std::uint64_t value_ = 0;
};

}  // namespace

std::uint64_t scene_hash(const SceneDescription& scene) {
    const auto& [file, camera, film, filter, sampler, integrator, camera_to_world, camera_moved_to, transform_times,
                 moved_to, camera_medium, color, materials, textures, media, shapes, objects, instances, lights,
                 area_lights, placeholders, warnings, general_code] = scene;
    // Placeholders are already in the scene; the sensor follows from film and camera, except in scenes made by hand.
    static_cast<void>(file), static_cast<void>(placeholders), static_cast<void>(warnings),
        static_cast<void>(general_code);
    SceneHash hash;
    // Records of renders in float and in double must not be merged.
    if (real_is_double) hash.add(real_is_double);
    for (const SceneEntity* entity : {&camera, &film, &filter, &sampler, &integrator}) hash.add(*entity);
    hash.add(camera_to_world);
    if (camera_moved_to || !moved_to.empty()) {
        for (const double time : transform_times) hash.add(time);
        if (camera_moved_to) hash.add(*camera_moved_to);
        hash.add(moved_to);
    }
    hash.add(camera_medium);
    hash.add(color.scene_space);
    for (const auto* matrix : {&color.rendering_from_scene, &color.sensor})
        for (const auto& row : *matrix)
            for (const double number : row) hash.add(number);
    hash.add(materials);
    hash.add(textures);
    hash.add(media);
    hash.add(shapes);
    hash.add(objects);
    hash.add(instances);
    hash.add(lights);
    hash.add(area_lights);
    return hash.value();
}

}  // namespace raylex::transport
