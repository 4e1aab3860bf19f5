// What the surfaces of a scene are called in cryptomattes. Surfaces count as EmbreeScene::surface_number() counts them.
//
// object    the label that a rule gave (a label other than the material's name); else the file of a mesh, as label
// rules
//           know it; else the kind of shape and its number among its like, in file order: "sphere:0", and
//           "leaf/sphere:0" for a shape that the object "leaf" defines. The label of an instance stands for all it
//           places.
// material  the named material; else its type and its number among the nameless of that type: "diffuse:2"
// asset     the instance, as label rules know it, "leaf:17"; a shape outside instances: its object name
#pragma once

#include <string>
#include <vector>

#include "geoaovs/cryptomatte.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// As pbrt's files call it: "trianglemesh", whatever it came from.
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
    std::vector<std::vector<Shape>> shapes_;  // [0] the top level, then every object's
    std::vector<Instance> instances_;
};

}  // namespace raylex::transport
