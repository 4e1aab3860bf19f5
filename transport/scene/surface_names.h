// The names of a scene's surfaces in cryptomattes. Surfaces are numbered as in EmbreeScene::surface_number().
//
// object    the label that a rule set (a label other than the material's name); else the file of a mesh, as in label
//           rules; else the kind of shape and its index among shapes of this kind, in file order: "sphere:0", or
//           "leaf/sphere:0" for a shape that the object "leaf" defines. The label of an instance applies to all shapes
//           that it places.
// material  the named material; else its type and its index among nameless materials of that type: "diffuse:2"
// asset     the instance as in label rules, "leaf:17"; for a shape outside instances: its object name
#pragma once

#include <string>
#include <vector>

#include "geoaovs/cryptomatte.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// pbrt's name for a kind of shape, such as "trianglemesh", whatever the shape came from.
[[nodiscard]] const char* shape_type_name(ShapeKind kind);

class SurfaceNames {
  public:
    SurfaceNames() = default;
    explicit SurfaceNames(const SceneDescription& scene);

    [[nodiscard]] geoaovs::MatteNames of(geoaovs::MatteKind kind) const;

  private:
    struct Shape {
        std::string object, material;
    };
    struct Instance {
        std::size_t object;
        std::string name, label;
    };
    std::vector<std::vector<Shape>> shapes_;  // [0] the top level, then the objects
    std::vector<Instance> instances_;
};

}  // namespace raylex::transport
