// A scene as described by its file: the importer's output and the scene builder's input. Plain data.
//
// Materials, textures, lights, camera, film, filter, sampler and integrator are stored as (type name, parameters). The
// registries interpret them, so a plugin's material needs no change here. Geometry is loaded, in the space in which it
// was written, beside its transform: the scene's build decides where to round. All rgb parameters are in
// `color.scene_space`, scene-linear. File names of materials, textures and lights ("filename", "normalmap", file
// spectra) are absolute and exist; every name of a material, texture or object resolves.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "transport/color/color_context.h"
#include "transport/math/transform.h"
#include "transport/math/vec.h"
#include "transport/scene/effect_set.h"

namespace raylex::transport {

/// An entity with a type and a list of parameters.
struct SceneEntity {
    std::string name;  ///< of a named material or texture; else empty
    std::string type;  ///< "diffuse", "imagemap", "path", ...
    ParameterSet parameters;
    SourceLocation location;
};

struct SceneTexture : SceneEntity {
    bool spectrum = false;  ///< colour-valued; false: a single float
    Transform to_world;     ///< current transform at its definition (planar, spherical ... mappings)
};

/// Whether a texture may use one that is defined after it: pbrt-v4 makes images first, then float textures, then colour
/// textures.
inline bool texture_may_come_later(const SceneTexture& user, const SceneTexture& used) {
    return used.type == "imagemap" || (user.spectrum && !used.spectrum);
}

/// A medium from MakeNamedMedium.
struct SceneMedium : SceneEntity {
    Transform to_world;  ///< current transform at its definition: the placement of its grid
};

enum class ShapeKind : std::uint8_t { triangle_mesh, bilinear_mesh, sphere, disk, cylinder, curves };

/// The kind of a curve: a ribbon that faces every ray, a tube, or a ribbon oriented by its normals.
enum class CurveType : std::uint8_t { flat, cylinder, ribbon };

/// One Shape directive, or several curves that share all but their points and widths: the numbers as written, and the
/// transform to the world (inside an ObjectBegin block: to the space in which instances place it).
struct SceneShape {
    ShapeKind kind = ShapeKind::triangle_mesh;
    std::string source_file;  ///< base name of a plymesh file; else empty
    SourceLocation location;

    std::vector<StoredVec3> positions, normals;  ///< object space; normals: one per position on the outside, or none
    std::vector<StoredVec2> uvs;                 ///< one per position, or none
    std::vector<std::uint32_t> indices;          ///< 3 per triangle, 4 per patch (p00 p10 p01 p11)
    // Curves of n cubic Bezier segments each: 3 n + 1 positions; `indices` contains the first position of each curve.
    // Ribbons have n + 1 unit normals as written, at the ends of segments.
    CurveType curve_type = CurveType::flat;
    std::vector<StoredVec2> curve_widths;  ///< of each curve, at its start and its end; linear in between
    std::string displacement_texture;      ///< of a plymesh: the name of a float texture, or empty
    Real edge_length = 1;                  ///< of a displaced mesh, in the world: longer edges are halved

    Real radius = 1, z_min = -1, z_max = 1, phi_max = 360;  ///< sphere, cylinder; degrees
    Real height = 0, inner_radius = 0;                      ///< disk
    Transform object_to_world;

    bool flip_normal = false;  ///< ReverseOrientation xor a transform that swaps handedness
    int material = -1;         ///< index into materials
    int area_light = -1;       ///< index into area_lights
    /// indices into media, -1 = none; if equal, the surface is not a border
    int inside_medium = -1, outside_medium = -1;
    Real alpha = 1;             ///< constant opacity
    std::string alpha_texture;  ///< name of a float texture; overrides alpha
    std::string label;          ///< LPE object label; as imported: the named material's name
    bool labelled = false;      ///< a label rule gave the label; see LabelRule
    bool holdout = false;       ///< set by a label rule; see LabelRule
};

struct SceneObject {
    std::string name;
    std::vector<SceneShape> shapes;
};

struct SceneInstance {
    int object = -1;  ///< index into objects
    Transform to_world;
    std::string label;            ///< set by a label rule: overrides the labels of the shapes
    std::optional<bool> holdout;  ///< set by a label rule: overrides the flag of the shapes
    SourceLocation location;
    std::int32_t motion = -1;  ///< index into SceneDescription::moved_to; -1: no motion
};

/// LightSource: point, spot, distant, infinite, ...
struct SceneLight : SceneEntity {
    Transform to_world;
    std::string group;  ///< LPE light group; empty = none
};

/// AreaLightSource: one per directive, shared by the shapes that follow it.
struct SceneAreaLight : SceneEntity {
    std::string group;
};

struct SceneDescription {
    std::string file;
    SceneEntity camera, film, filter, sampler, integrator;  ///< type empty: not given, defaults apply
    Transform camera_to_world;
    std::optional<Transform> camera_moved_to;     ///< camera to world at the end, if the camera moves
    std::array<double, 2> transform_times{0, 1};  ///< the times at which motion starts and ends
    std::vector<Transform> moved_to;              ///< for instances that move: transforms to the world at the end
    int camera_medium = -1;                       ///< index into media; -1 = none
    ColorContext color;
    std::vector<SceneEntity> materials;  ///< [0] is the default diffuse material
    std::vector<SceneTexture> textures;
    std::vector<SceneMedium> media;
    std::vector<SceneShape> shapes;
    std::vector<SceneObject> objects;
    std::vector<SceneInstance> instances;
    std::vector<SceneLight> lights;
    std::vector<SceneAreaLight> area_lights;
    std::vector<std::string> placeholders;  ///< files that are missing and replaced by magenta
    std::vector<Error> warnings;            ///< unknown but harmless input: printed once, stored for --stats
    /// Effects that are forced on: their code runs even if nothing in the scene uses them. The image has the same bits.
    EffectSet general_code;
};

/// A rule that sets labels of objects or groups of lights of an unmodified scene. Exactly one selector is set; globs (*
/// and ?).
struct LabelRule {
    enum class Selector : std::uint8_t { material, mesh_file, instance, light, area_light_material };
    Selector selector = Selector::material;
    std::string pattern;  ///< light: "infinite", "spot:1", "area:0" (kind, or kind:index in file order), globs
    std::string label;    ///< object label, or light group for the light selectors
    SourceLocation location;
    /// For objects only. If a camera ray hits a holdout first, its sample leaves the beauty, its alpha and all channels
    /// except those with the prefix `holdouts`: a holdout stands for an object that the plate already shows.
    std::optional<bool> holdout{};
    bool keeps_label = false;  ///< the rule sets holdouts only
};

/// Applies the rules. The first matching rule wins per object and per light, separately for the label and for the
/// holdout flag. Objects without a matching rule keep their label (shapes: the name of their named material, as
/// imported). Area lights have the kind "area", one per AreaLightSource in file order; an instance is matched by its
/// object's name or name:index. A rule that matches nothing is an Error that lists close matches; one that matches only
/// objects of earlier rules adds a warning.
Status apply_label_rules(SceneDescription& scene, const std::vector<LabelRule>& rules);

}  // namespace raylex::transport
