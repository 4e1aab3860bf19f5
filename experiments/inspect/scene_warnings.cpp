#include "experiments/inspect/scene_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "experiments/inspect/closed_meshes.h"
#include "experiments/program/console.h"
#include "transport/geometry/shapes/placed_mesh.h"

namespace raylex::experiments {
namespace {

using transport::DVec3;
using transport::SceneDescription;
using transport::SceneShape;
using transport::ShapeKind;

using Warnings = std::vector<Error>;

/// All names and indices that something in the scene refers to.
struct Used {
    std::set<std::string> textures, media;
    std::set<std::string> material_names;  // used by mixes
    std::set<int> materials, area_lights, objects;
};

void add_references(const transport::SceneEntity& entity, Used& used) {
    for (const Parameter& parameter : entity.parameters.parameters) {
        if (parameter.type == ParameterType::texture)
            used.textures.insert(parameter.strings.begin(), parameter.strings.end());
        if (parameter.name == "materials")
            used.material_names.insert(parameter.strings.begin(), parameter.strings.end());
    }
}

Used everything_used(const SceneDescription& scene) {
    Used used;
    std::set<int> media{scene.camera_medium};
    const auto add = [&](const SceneShape& shape) {
        used.materials.insert(std::max(shape.material, 0));
        used.area_lights.insert(shape.area_light);
        media.insert({shape.inside_medium, shape.outside_medium});
        used.textures.insert({shape.alpha_texture, shape.displacement_texture});
    };
    for (const SceneShape& shape : scene.shapes) add(shape);
    for (const transport::SceneObject& object : scene.objects)
        for (const SceneShape& shape : object.shapes) add(shape);
    for (const transport::SceneInstance& instance : scene.instances) used.objects.insert(instance.object);
    for (const auto& each : scene.materials) add_references(each, used);
    for (const auto& each : scene.textures) add_references(each, used);
    for (const auto& each : scene.lights) add_references(each, used);
    for (const auto& each : scene.area_lights) add_references(each, used);
    for (const auto& each : scene.media) add_references(each, used);
    for (const int medium : media)
        if (medium >= 0) used.media.insert(scene.media[static_cast<std::size_t>(medium)].name);
    used.textures.erase("");
    return used;
}

/// Returns whether one name may be a misspelling of the other. Names that differ in a number belong to a series and do
/// not count.
bool is_typo(std::string_view a, std::string_view b) {
    const auto letters = [](std::string_view name) {
        std::string kept;
        for (const char c : name)
            if (c < '0' || c > '9') kept += c;
        return kept;
    };
    return letters(a) != letters(b) && edit_distance(a, b) <= 2;
}

/// Warns of a defined name that nothing uses. The hint is a used name that is similar.
void check_unused(const transport::SceneEntity& entity, const char* what, const std::set<std::string>& used,
                  Warnings& warnings) {
    if (entity.name.empty() || used.count(entity.name) > 0) return;
    const std::string near = nearest_name(entity.name, {used.begin(), used.end()});
    warnings.push_back(
        error_at(entity.location, std::string("the ") + what + " '" + entity.name + "' is unused",
                 near.empty() || !is_typo(entity.name, near) ? "" : "'" + near + "' is used; did you mean this?"));
}

void check_unused_entities(const SceneDescription& scene, const Used& used, Warnings& warnings) {
    std::set<std::string> materials = used.material_names;
    for (const int material : used.materials)
        if (static_cast<std::size_t>(material) < scene.materials.size())
            materials.insert(scene.materials[static_cast<std::size_t>(material)].name);
    materials.erase("");
    for (const auto& each : scene.materials) check_unused(each, "material", materials, warnings);
    for (const auto& each : scene.textures) check_unused(each, "texture", used.textures, warnings);
    for (const auto& each : scene.media) check_unused(each, "medium", used.media, warnings);
    for (std::size_t i = 0; i < scene.area_lights.size(); ++i)
        if (used.area_lights.count(static_cast<int>(i)) == 0)
            warnings.push_back(error_at(scene.area_lights[i].location,
                                        "no emitting shape follows this area light, so it gives no light"));
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (used.objects.count(static_cast<int>(i)) == 0)
            warnings.push_back(error_at(scene.objects[i].shapes.empty() ? SourceLocation{scene.file, 0, 0}
                                                                        : scene.objects[i].shapes.front().location,
                                        "the object '" + scene.objects[i].name + "' has no instance"));
}

/// Counts of a mesh's faces.
struct FaceCounts {
    std::size_t faces = 0, degenerate_uv = 0, torn_normals = 0;
};

DVec3 at(const std::vector<transport::StoredVec3>& values, std::uint32_t i) {
    return DVec3(values[i]);
}

/// Returns twice the area of a face in texture space. Corners are in order; a triangle repeats its last corner.
double uv_area(const SceneShape& shape, const std::array<std::uint32_t, 4>& around) {
    double area = 0;
    for (std::size_t i = 1; i + 1 < around.size(); ++i) {
        const auto side = [&](std::size_t corner) {
            const auto &to = shape.uvs[around[corner]], &from = shape.uvs[around[0]];
            return std::pair{double(to.x) - from.x, double(to.y) - from.y};
        };
        const auto [ux, uy] = side(i);
        const auto [vx, vy] = side(i + 1);
        area += std::abs(ux * vy - uy * vx);
    }
    return area;
}

FaceCounts count_faces(const SceneShape& shape) {
    FaceCounts counts;
    const bool triangles = shape.kind == ShapeKind::triangle_mesh;
    const std::size_t corners = triangles ? 3 : 4;
    counts.faces = shape.indices.size() / corners;
    for (std::size_t face = 0; face < counts.faces; ++face) {
        const std::uint32_t* of = shape.indices.data() + face * corners;
        const std::array<std::uint32_t, 4> around =
            triangles ? std::array{of[0], of[1], of[2], of[2]} : std::array{of[0], of[1], of[3], of[2]};
        // The cross product of a patch's diagonals; of a triangle, which repeats its last corner, that of two sides.
        const auto corner = [&](std::size_t i) { return at(shape.positions, around[i]); };
        const DVec3 n = cross(corner(2) - corner(0), corner(3) - corner(1));
        if (!shape.uvs.empty()) counts.degenerate_uv += uv_area(shape, around) == 0;
        bool front = false, back = false;
        for (std::size_t i = 0; i < corners && !shape.normals.empty(); ++i) {
            const double side = dot(n, at(shape.normals, around[i]));
            front = front || side > 0;
            back = back || side < 0;
        }
        counts.torn_normals += front && back;
    }
    return counts;
}

/// Finds whether materials, mixes and textures use texture coordinates.
class TexturedBy {
  public:
    explicit TexturedBy(const SceneDescription& scene) : scene_(scene) {
        for (const transport::SceneTexture& texture : scene.textures) textures_.emplace(texture.name, &texture);
        for (const transport::SceneEntity& material : scene.materials) materials_.emplace(material.name, &material);
    }
    [[nodiscard]] bool coordinates(const SceneShape& shape) {
        return texture(shape.alpha_texture) || texture(shape.displacement_texture) ||
               (shape.material >= 0 && static_cast<std::size_t>(shape.material) < scene_.materials.size() &&
                parameters(scene_.materials[static_cast<std::size_t>(shape.material)]));
    }

  private:
    bool parameters(const transport::SceneEntity& entity) {
        if (!seen_.insert(&entity).second) return answers_[&entity];
        bool& answer = answers_[&entity];
        for (const Parameter& parameter : entity.parameters.parameters) {
            answer = answer || parameter.name == "normalmap";
            for (const std::string& name : parameter.strings) {
                if (parameter.type == ParameterType::texture) answer = answer || texture(name);
                if (parameter.name != "materials") continue;
                const auto part = materials_.find(name);
                answer = answer || (part != materials_.end() && parameters(*part->second));
            }
        }
        return answer;
    }
    bool texture(const std::string& name) {
        const auto [first, last] = textures_.equal_range(name);
        return std::any_of(first, last, [&](const auto& each) {
            const transport::SceneTexture& texture = *each.second;
            static const std::set<std::string> placed{"imagemap", "checkerboard", "dots", "bilerp"};
            const auto mapping = texture.parameters.string_or("mapping", "uv");
            return (placed.count(texture.type) > 0 && mapping && *mapping == "uv") || parameters(texture);
        });
    }

    const SceneDescription& scene_;
    std::multimap<std::string, const transport::SceneTexture*> textures_;
    std::map<std::string, const transport::SceneEntity*> materials_;
    std::set<const transport::SceneEntity*> seen_;  // visited entities, because mixes can refer to themselves
    std::map<const transport::SceneEntity*, bool> answers_;
};

void check_shape(const SceneShape& shape, TexturedBy& textured, Warnings& warnings) {
    if (shape.kind != ShapeKind::triangle_mesh && shape.kind != ShapeKind::bilinear_mesh) return;
    const FaceCounts counts = count_faces(shape);
    const auto warning = [&](std::size_t count, const std::string& what) {
        if (count == 0) return;
        warnings.push_back(error_at(shape.location, std::to_string(count) + " of " + std::to_string(counts.faces) +
                                                        " faces of " + transport::mesh_name(shape) + " " + what));
    };
    if (counts.faces == 0) warnings.push_back(error_at(shape.location, transport::mesh_name(shape) + " has no faces"));
    if (counts.degenerate_uv > 0 && textured.coordinates(shape))
        warning(counts.degenerate_uv, "have collinear texture coordinates and a material with textures");
    warning(counts.torn_normals, "have vertex normals on both sides of the face");
}

/// Returns the bounds of a mesh in the space of its shape list.
transport::Bounds bounds_of(const SceneShape& shape) {
    constexpr transport::Real far = std::numeric_limits<transport::Real>::infinity();
    transport::Bounds bounds{{far, far, far}, {-far, -far, -far}};
    for (const auto& position : shape.positions) {
        const transport::Vec3 p = shape.object_to_world.point(transport::Vec3(position));
        for (int i = 0; i < 3; ++i) {
            bounds.lower[i] = std::min(bounds.lower[i], p[i]);
            bounds.upper[i] = std::max(bounds.upper[i], p[i]);
        }
    }
    return bounds;
}

bool lies_in(const transport::Bounds& inner, const transport::Bounds& outer) {
    for (int i = 0; i < 3; ++i)
        if (inner.lower[i] < outer.lower[i] || inner.upper[i] > outer.upper[i]) return false;
    return true;
}

/// Warns of a closed medium boundary that faces inwards: it fills the space around it, unless it is a hole in another
/// one.
void check_bodies(const SceneDescription& scene, const std::vector<SceneShape>& shapes, Warnings& warnings) {
    for (const SceneShape& shape : shapes) {
        const bool body =
            shape.material >= 0 && scene.materials[static_cast<std::size_t>(shape.material)].type == "subsurface";
        // Without a body, fog that an inward-facing room contains is correct.
        if (!body && (shape.inside_medium < 0 || shape.inside_medium == shape.outside_medium)) continue;
        const auto volume = enclosed_volume(shape);
        if (!volume || *volume >= 0) continue;
        const transport::Bounds bounds = bounds_of(shape);
        const bool within_another = std::any_of(shapes.begin(), shapes.end(), [&](const SceneShape& other) {
            const bool alike = body ? other.material == shape.material : other.inside_medium == shape.inside_medium;
            return alike && &other != &shape &&
                   (other.positions.empty() || lies_in(bounds, bounds_of(other)));  // a quadric may contain it
        });
        if (!within_another)
            warnings.push_back(error_at(shape.location, transport::mesh_name(shape) +
                                                            " is closed and faces inwards, so its medium fills the "
                                                            "space around it; ReverseOrientation flips it"));
    }
}

}  // namespace

std::vector<Error> scene_warnings(const SceneDescription& scene, const transport::BuiltScene& built) {
    Warnings warnings;
    TexturedBy textured(scene);
    for (const SceneShape& shape : scene.shapes) check_shape(shape, textured, warnings);
    for (const transport::SceneObject& object : scene.objects)
        for (const SceneShape& shape : object.shapes) check_shape(shape, textured, warnings);
    check_bodies(scene, scene.shapes, warnings);
    for (const transport::SceneObject& object : scene.objects) check_bodies(scene, object.shapes, warnings);
    warnings.insert(warnings.end(), built.dark_lights.begin(), built.dark_lights.end());
    // A placeholder mesh has its own material, so any unused definition may belong to the missing mesh.
    const auto is_mesh = [](const std::string& file) { return file.ends_with(".ply") || file.ends_with(".ply.gz"); };
    if (std::none_of(scene.placeholders.begin(), scene.placeholders.end(), is_mesh))
        check_unused_entities(scene, everything_used(scene), warnings);
    return warnings;
}

}  // namespace raylex::experiments
