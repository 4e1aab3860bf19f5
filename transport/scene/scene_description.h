// A scene as its file describes it: the importer's output and the scene builder's input. Plain data.
//
// Materials, textures, lights, camera, film, filter, sampler and integrator stay (type name, parameters): the
// registries give them meaning, so that a plugin's material needs no change here. Geometry is loaded and stands in the
// space it was written in, beside its transform: what is rounded where is decided when the scene is built. All rgb
// parameters are in `color.scene_space`, scene-linear. File names that materials, textures and lights read
// ("filename", "normalmap", file spectra) are absolute and exist; every name of a material, texture or object resolves.
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

/// Anything named by a type and a list of parameters.
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

/// Whether a texture may use one that is defined after it: pbrt-v4 makes images first, then float textures, then
/// colours.
inline bool texture_may_come_later(const SceneTexture& user, const SceneTexture& used) {
    return used.type == "imagemap" || (user.spectrum && !used.spectrum);
}

/// By MakeNamedMedium.
struct SceneMedium : SceneEntity {
    Transform to_world;  ///< current transform at its definition: where its grid stands
};

enum class ShapeKind : std::uint8_t { triangle_mesh, bilinear_mesh, sphere, disk, cylinder, curves };

/// What a curve's width is of: a ribbon that faces every ray, a tube, or a ribbon that its normals turn.
enum class CurveType : std::uint8_t { flat, cylinder, ribbon };

/// One Shape directive, or as many curves as share all but their points and widths: numbers as they were written, and
/// the transform to the world (inside an ObjectBegin block: to the space in which instances place it).
struct SceneShape {
    ShapeKind kind = ShapeKind::triangle_mesh;
    std::string source_file;  ///< base name of a plymesh file; else empty
    SourceLocation location;

    std::vector<StoredVec3> positions, normals;  ///< object space; normals: one per position on the outside, or none
    std::vector<StoredVec2> uvs;                 ///< one per position, or none
    std::vector<std::uint32_t> indices;          ///< 3 per triangle, 4 per patch (p00 p10 p01 p11)
    // Curves of n cubic Bezier segments each: 3 n + 1 positions, `indices` saying where each curve's begin, and for
    // ribbons n + 1 unit normals as written, at the ends of segments.
    CurveType curve_type = CurveType::flat;
    std::vector<StoredVec2> curve_widths;  ///< of each curve, at its start and end; linear between
    std::string displacement_texture;      ///< of a plymesh: a float texture, or none
    Real edge_length = 1;                  ///< of a displaced mesh, in the world: longer edges are halved first

    Real radius = 1, z_min = -1, z_max = 1, phi_max = 360;  ///< sphere, cylinder; degrees
    Real height = 0, inner_radius = 0;                      ///< disk
    Transform object_to_world;

    bool flip_normal = false;                     ///< ReverseOrientation xor a transform that swaps handedness
    int material = -1;                            ///< index into materials
    int area_light = -1;                          ///< index into area_lights
    int inside_medium = -1, outside_medium = -1;  ///< indices into media, -1 = none; alike: the surface is no border
    Real alpha = 1;                               ///< constant opacity
    std::string alpha_texture;                    ///< name of a float texture; overrides alpha
    std::string label;                            ///< LPE object label; as imported: the named material's name
    bool labelled = false;                        ///< a label rule gave the label; see LabelRule
    bool holdout = false;                         ///< set by a label rule; see LabelRule
};

struct SceneObject {
    std::string name;
    std::vector<SceneShape> shapes;
};

struct SceneInstance {
    int object = -1;  ///< index into objects
    Transform to_world;
    std::string label;            ///< set by a label rule: overrides the shapes' own labels
    std::optional<bool> holdout;  ///< set by a label rule: overrides the shapes' own
    SourceLocation location;
    std::int32_t motion = -1;  ///< index into SceneDescription::moved_to; -1: it stands still
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
    std::array<double, 2> transform_times{0, 1};  ///< when what moves is where it starts, and where it ends
    std::vector<Transform> moved_to;              ///< of instances that move: to the world at the end
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
    std::vector<std::string> placeholders;  ///< files that are missing and have magenta in their place
    std::vector<Error> warnings;            ///< unknown but harmless: printed once, kept for --stats
    /// Effects that are forced on: their code runs though nothing may call for it. The image is the same bits.
    EffectSet general_code;
};

/// Gives labels to objects and groups to lights of an unmodified scene. Exactly one selector is set; globs (* and ?).
struct LabelRule {
    enum class Selector : std::uint8_t { material, mesh_file, instance, light, area_light_material };
    Selector selector = Selector::material;
    std::string pattern;  ///< light: "infinite", "spot:1", "area:0" (kind, or kind:index in file order), globs
    std::string label;    ///< object label, or light group for the light selectors
    SourceLocation location;
    /// Objects only. What a camera ray finds first at a holdout leaves the beauty, its alpha and all channels but those
    /// with the prefix `holdouts`: a stand-in for what the plate shows already.
    std::optional<bool> holdout{};
    bool keeps_label = false;  ///< the rule speaks of holdouts alone
};

/// First matching rule wins per object and per light, for the label and for being a holdout apart; what no rule matches
/// keeps its label (shapes: the name of their named material, as imported). Area lights count as kind "area", one per
/// AreaLightSource in file order; an instance goes by its object's name or name:index. A rule that matches nothing is
/// an Error that lists near misses; one that matches only what earlier rules took adds a warning.
Status apply_label_rules(SceneDescription& scene, const std::vector<LabelRule>& rules);

}  // namespace raylex::transport
