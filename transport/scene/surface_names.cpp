#include "transport/scene/surface_names.h"

#include <algorithm>
#include <map>
#include <utility>

namespace raylex::transport {

const char* shape_type_name(ShapeKind kind) {
    switch (kind) {
        case ShapeKind::triangle_mesh:
            return "trianglemesh";
        case ShapeKind::bilinear_mesh:
            return "bilinearmesh";
        case ShapeKind::sphere:
            return "sphere";
        case ShapeKind::disk:
            return "disk";
        case ShapeKind::cylinder:
            return "cylinder";
        case ShapeKind::curves:
            return "curve";
    }
    return "";
}

namespace {

std::vector<std::string> material_names(const SceneDescription& scene) {
    std::map<std::string, int> count;
    std::vector<std::string> names;
    for (const SceneEntity& material : scene.materials) {
        const std::string type = material.type.empty() ? "interface" : material.type;
        names.push_back(material.name.empty() ? type + ":" + std::to_string(count[type]++) : material.name);
    }
    return names;
}

/// Assigns a number to every distinct string, in order of appearance.
class Numbering {
  public:
    explicit Numbering(geoaovs::MatteNames& names) : names_(names) {}
    void add(const std::string& name) {
        const auto [at, fresh] = known_.emplace(name, static_cast<std::uint32_t>(names_.names.size()));
        if (fresh) names_.names.push_back(name);
        names_.of_surface.push_back(at->second);
    }

  private:
    geoaovs::MatteNames& names_;
    std::map<std::string, std::uint32_t> known_;
};

}  // namespace

SurfaceNames::SurfaceNames(const SceneDescription& scene) {
    const std::vector<std::string> materials = material_names(scene);
    const auto add_shapes = [&](const std::vector<SceneShape>& shapes, const std::string& prefix) {
        std::map<ShapeKind, int> count;
        std::vector<Shape>& named = shapes_.emplace_back();
        for (const SceneShape& shape : shapes) {
            const auto index = static_cast<std::size_t>(std::max(shape.material, 0));
            const std::string own = index < scene.materials.size() ? scene.materials[index].name : std::string();
            std::string name = prefix + shape_type_name(shape.kind) + ":" + std::to_string(count[shape.kind]++);
            if (shape.labelled || (!shape.label.empty() && shape.label != own)) name = shape.label;
            else if (!shape.source_file.empty()) name = shape.source_file;
            named.push_back({std::move(name), index < materials.size() ? materials[index] : "diffuse:0"});
        }
    };
    add_shapes(scene.shapes, "");
    for (const SceneObject& object : scene.objects) add_shapes(object.shapes, object.name + "/");
    std::map<int, int> count;
    for (const SceneInstance& instance : scene.instances) {
        if (instance.object < 0 || static_cast<std::size_t>(instance.object) >= scene.objects.size()) continue;
        const auto object = static_cast<std::size_t>(instance.object);
        instances_.push_back(
            {object, scene.objects[object].name + ":" + std::to_string(count[instance.object]++), instance.label});
    }
}

geoaovs::MatteNames SurfaceNames::of(geoaovs::MatteKind kind) const {
    geoaovs::MatteNames names;
    Numbering numbering(names);
    if (!shapes_.empty())
        for (const Shape& shape : shapes_.front())
            numbering.add(kind == geoaovs::MatteKind::material ? shape.material : shape.object);
    for (const Instance& instance : instances_)
        for (const Shape& shape : shapes_[instance.object + 1]) {
            if (kind == geoaovs::MatteKind::material) numbering.add(shape.material);
            else if (kind == geoaovs::MatteKind::asset) numbering.add(instance.name);
            else numbering.add(instance.label.empty() ? shape.object : instance.label);
        }
    return names;
}

}  // namespace raylex::transport
