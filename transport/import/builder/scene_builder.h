// Makes a SceneDescription in code: one call for every camera, film, material, texture, light, medium, shape, object
// and instance. The importer of pbrt files makes its scenes by these calls too, so that there is one place that knows
// names, checks parameters and refuses what does not fit.
//
//     using namespace raylex::transport::typed;  // real(), rgb() ...
//     SceneBuilder scene("my scene");
//     scene.set_camera("perspective", {real("fov", 40)}, Transform::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}));
//     const auto grey = scene.add_material("diffuse", {rgb("reflectance", {0.5, 0.5, 0.5})});
//     if (!grey) return grey.error();
//     if (Status s = scene.add_shape("sphere", {real("radius", 1)}, {.material = *grey}); !s) return s.error();
//     Result<SceneDescription> description = scene.finish();
//
// Types, parameters and defaults are those of pbrt-v4's file format and of plugins (`raylex plugins`). Points and
// directions stand in the space of the transform given with them; rgb in the colour space of the scene. Errors name the
// source file and line of the call.
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "transport/files/input_file.h"
#include "transport/import/known_parameters.h"
#include "transport/scene/loading_progress.h"
#include "transport/scene/missing_files.h"
#include "transport/scene/scene_description.h"
#include "transport/scene/typed_parameters.h"

namespace raylex::transport {

/// A name, and where it was written when that is not where the call is.
struct SceneName {
    SceneName(const char* name) : text(name) {}             // NOLINT(google-explicit-constructor)
    SceneName(std::string name) : text(std::move(name)) {}  // NOLINT(google-explicit-constructor)
    SceneName(std::string name, SourceLocation at) : text(std::move(name)), where(std::move(at)) {}
    [[nodiscard]] const SourceLocation& place(const SourceLocation& call) const {
        return where.file.empty() ? call : where;
    }
    std::string text;
    SourceLocation where;
};

/// What a call gives to a type.
struct SceneParameters {
    SceneParameters() = default;
    SceneParameters(std::initializer_list<Parameter> list) { own.parameters = list; }
    SceneParameters(ParameterSet set) : own(std::move(set)) {}  // NOLINT(google-explicit-constructor)
    ParameterSet own;                                           ///< the type must know them all
    std::vector<Parameter> fallbacks;  ///< fill gaps; what means nothing to the type is left out (pbrt's Attribute)
};

/// What calls hand out, for other calls of the same builder: any other refuses it. The values are its own business;
/// what a caller makes is the default, which is every builder's.
struct MaterialHandle {
    int reference = 0;          ///< by default the first material: diffuse, reflectance 0.5
    std::uint32_t builder = 0;  ///< who handed it out; 0: nobody
};
struct MediumHandle {
    int reference = -1;  ///< vacuum
    std::uint32_t builder = 0;
};
struct AreaLightHandle {
    int reference = -1;  ///< dark
    std::uint32_t builder = 0;
};
struct ObjectHandle {
    int reference = -1;  ///< none: shapes stand in the scene itself
    std::uint32_t builder = 0;
};

enum class TextureValue : std::uint8_t { real, spectrum };

/// Where a shape stands, and what it is made of.
struct ShapePlacement {
    Transform to_world{};  ///< in an object: to the object's space
    /// Where it ends, if it moves: it becomes an object of its own, and an instance of that. In an object, all
    /// instances of that place it too, by transforms in which theirs and its own are one.
    std::optional<Transform> moved_to{};
    MaterialHandle material{};
    AreaLightHandle area_light{};  ///< not in an object: instances do not emit (pbrt's rule)
    MediumHandle inside{}, outside{};
    bool reverse_orientation = false;
    ObjectHandle object{};  ///< the object that it is part of
    std::string label{};    ///< LPE object label; empty: the name of its material
};

/// A mesh without a file. Normals and texture coordinates: one a vertex, or none.
struct MeshData {
    std::vector<StoredVec3> positions;
    std::vector<std::uint32_t> indices;  ///< three a triangle; four a bilinear patch, p00 p10 p01 p11
    std::vector<StoredVec3> normals{};
    std::vector<StoredVec2> uvs{};
    bool patches = false;
};

/// Curves without a file, as many as share material and type: cubic Bezier segments, 3 n + 1 points a curve.
struct CurveData {
    CurveType type = CurveType::flat;
    std::vector<StoredVec3> points;
    std::vector<std::uint32_t> first_points;  ///< of each curve
    std::vector<StoredVec2> widths;           ///< of each curve, at its start and end
    std::vector<StoredVec3> normals{};        ///< ribbons: n + 1 a curve
};

class SceneBuilder {
  public:
    /// `file` is what the scene goes by in messages. Relative names of files are looked for in `search`: by default in
    /// the current folder.
    explicit SceneBuilder(std::string file, SearchPath search = {});
    // A copy's handles would be those of the original, though each goes its own way.
    SceneBuilder(const SceneBuilder&) = delete;
    SceneBuilder& operator=(const SceneBuilder&) = delete;
    SceneBuilder(SceneBuilder&&) = default;
    SceneBuilder& operator=(SceneBuilder&&) = default;
    ~SceneBuilder() = default;
    void set_search(SearchPath search) { search_ = std::move(search); }
    /// What a file that is not there does; by default it is refused.
    void set_missing_files(MissingFiles missing) { missing_ = missing; }

    // The last argument of calls is where they stand, by default in the source that calls.

    /// Of all colours in parameters and textures; before any of them.
    void set_color_space(ColorSpace space) { scene_.color.scene_space = space; }
    [[nodiscard]] ColorSpace color_space() const { return scene_.color.scene_space; }
    Status set_film(const std::string& type, SceneParameters parameters,
                    const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status set_filter(const std::string& type, SceneParameters parameters,
                      const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status set_sampler(const std::string& type, SceneParameters parameters,
                       const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status set_integrator(const std::string& type, SceneParameters parameters,
                          const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// `world_to_camera` as Transform::look_at gives it; `moved_to` too, if the camera moves.
    Status set_moving_camera(const std::string& type, SceneParameters parameters, const Transform& world_to_camera,
                             const Transform& moved_to, MediumHandle medium = {},
                             const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// When what moves starts and when it ends, by the clock of the camera's "shutteropen" and "shutterclose"; by
    /// default at 0 and 1. How things go from here to there: math/animated_transform.h.
    Status set_transform_times(double start, double end,
                               const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// `world_to_camera` as Transform::look_at gives it.
    Status set_camera(const std::string& type, SceneParameters parameters, const Transform& world_to_camera,
                      MediumHandle medium = {}, const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    Result<MaterialHandle> add_material(const std::string& type, SceneParameters parameters,
                                        const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Result<MaterialHandle> add_named_material(const SceneName& name, const std::string& type,
                                              SceneParameters parameters,
                                              const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// A material that is defined somewhere, perhaps later.
    MaterialHandle material_named(const SceneName& name,
                                  const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// `to_world` is where a grid's box stands.
    Result<MediumHandle> add_medium(const SceneName& name, const std::string& type, SceneParameters parameters,
                                    const Transform& to_world = {},
                                    const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// A medium that is defined somewhere, perhaps later.
    MediumHandle medium_named(const SceneName& name,
                              const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// `to_world` is what mappings other than uv stand in. Textures may use those before them; materials use any.
    Status add_texture(const SceneName& name, TextureValue value, const std::string& type, SceneParameters parameters,
                       const Transform& to_world = {},
                       const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_light(const std::string& type, SceneParameters parameters, const Transform& to_world = {},
                     const std::string& group = {}, const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// Makes all shapes that are placed with it emit.
    Result<AreaLightHandle> add_area_light(const std::string& type, SceneParameters parameters,
                                           const std::string& group = {},
                                           const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_shape(const std::string& type, SceneParameters parameters, const ShapePlacement& placement = {},
                     const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_mesh(const MeshData& mesh, const ShapePlacement& placement = {},
                    const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    Status add_curves(const CurveData& curves, const ShapePlacement& placement = {},
                      const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    Result<ObjectHandle> add_object(const SceneName& name,
                                    const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// An object that is defined somewhere, perhaps later.
    ObjectHandle object_named(const SceneName& name,
                              const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_instance(ObjectHandle object, const Transform& to_world = {},
                        const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_moving_instance(ObjectHandle object, const Transform& to_world, const Transform& moved_to,
                               const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    /// All images are read as they are, whatever their textures' "filter" says.
    void disable_texture_filtering() { unfiltered_ = true; }
    /// Of all displaced meshes, whatever their own "edgelength" is.
    Status scale_displacement_edges(double factor, const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    /// What the scene's reader should hear of: SceneDescription::warnings.
    void warn(Error warning) { scene_.warnings.push_back(std::move(warning)); }

    /// How many threads read meshes; 0: all. `progress`, if any, is told how many there are and how many are read.
    void set_loading(int threads, LoadingProgress* progress) { threads_ = threads, progress_ = progress; }

    /// Reads mesh files, resolves names and hands over the scene. Errors: a mesh that cannot be read, a name that
    /// nothing has and a shape, the camera or another entity uses. The builder is spent either way, and refuses more.
    Result<SceneDescription> finish(const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

  private:
    struct Reference {
        int index = -1;  ///< -1: by name
        std::string name;
        SourceLocation location;
    };

    // scene_builder_handles.cpp
    /// A handle as calls hand it out.
    template <typename Handle>
    [[nodiscard]] Handle handle(int reference) const {
        return {reference, id_};
    }
    template <typename Handle>
    Status check_handle(const Handle& handle, const char* what, const SourceLocation& where) const;
    Status check_open(const SourceLocation& where) const;
    Status check_placement(const ShapePlacement& placement, const SourceLocation& where) const;
    Status check_instance(ObjectHandle object, const Transform& to_world, const SourceLocation& where) const;
    // scene_builder.cpp
    Status settings(SceneEntity& target, EntityKind kind, const std::string& type, SceneParameters parameters,
                    const SourceLocation& where);
    /// `float_texture`: a texture of single numbers.
    Result<SceneEntity> make_entity(const std::string& type, EntityKind kind, SceneParameters parameters,
                                    const SourceLocation& where, bool float_texture = false);
    Result<ParameterSet> checked(const std::string& type, EntityKind kind, SceneParameters parameters,
                                 const SourceLocation& where, bool float_texture = false);
    Status resolve_files(ParameterSet& set) const;
    /// Resolves an entity's files, or puts something magenta in its place, with a warning.
    Status resolve_entity(SceneEntity& entity, bool float_texture);
    void count_placeholder(const std::string& file, const SourceLocation& where);
    /// A box of magenta from -0.5 to 0.5 where a mesh's file is missing.
    Status place_missing_mesh(const std::string& file, const ShapePlacement& placement, const SourceLocation& where);
    // scene_builder_shapes.cpp
    /// Where shapes go: the scene's own, or an object's.
    Result<std::vector<SceneShape>*> shapes_of(const ShapePlacement& placement, const SourceLocation& where);
    Status place(std::vector<SceneShape> shapes, const ShapePlacement& placement, const SourceLocation& where);
    void append(std::vector<SceneShape>& target, std::vector<SceneShape> shapes, const ShapePlacement& placement);
    Result<ShapePlacement> as_moving_object(const ShapePlacement& placement, const SourceLocation& where);
    Status add_flattened(const std::string& type, const ParameterSet& set, const ShapePlacement& placement,
                         const SourceLocation& where);
    Status place_moving_parts();
    // scene_builder_meshes.cpp
    Status read_meshes();
    // scene_builder_names.cpp
    Status resolve_materials();
    Status resolve_media();
    Status resolve_objects();
    Status check_textures() const;
    Status check_shape(const SceneShape& shape) const;
    [[nodiscard]] bool has_texture(const std::string& name, bool spectrum, bool any_kind, std::size_t before) const;
    Error no_such_texture(const std::string& name, const SourceLocation& where, const char* kind) const;

    /// A mesh file that read_meshes() reads, with the place that its shapes and warnings have in the order of calls.
    struct NamedMesh {
        ParameterSet parameters;
        Transform to_world;
        ShapePlacement placement;
        SearchPath search;
        std::size_t shapes_before, warnings_before;
    };
    /// A shape that moves in the object whose reference is `object`: an object of its own.
    struct MovingPart {
        int object;
        ObjectHandle part;
        Transform first, last;
        SourceLocation location;
    };

    static std::uint32_t next_id();

    std::uint32_t id_ = next_id();
    bool spent_ = false;
    SceneDescription scene_;
    SearchPath search_;
    MissingFiles missing_ = MissingFiles::refused;
    ParameterChecker parameters_;
    std::vector<Reference> material_references_, media_references_, object_references_;
    std::vector<NamedMesh> meshes_;
    std::vector<MovingPart> moving_parts_;
    std::size_t moving_shapes_ = 0;
    bool unfiltered_ = false;
    double edge_scale_ = 1;
    int threads_ = 0;
    LoadingProgress* progress_ = nullptr;
    std::map<std::string, int> named_materials_, named_media_, named_objects_, object_reference_of_,
        medium_reference_of_;
    std::map<std::string, std::size_t> named_textures_[2];  // float, spectrum
};

}  // namespace raylex::transport
