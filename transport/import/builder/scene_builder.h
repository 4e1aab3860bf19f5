// Makes a SceneDescription in code: one call for every camera, film, material, texture, light, medium, shape, object
// and instance. The importer of pbrt files uses the same calls, so names are resolved and parameters checked in one
// place.
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
// directions are in the space of the transform passed with them; rgb is in the colour space of the scene. Errors name
// the source file and line of the call.
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

/// A name, with its position if that differs from the position of the call.
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

/// The parameters of an entity.
struct SceneParameters {
    SceneParameters() = default;
    SceneParameters(std::initializer_list<Parameter> list) { own.parameters = list; }
    SceneParameters(ParameterSet set) : own(std::move(set)) {}  // NOLINT(google-explicit-constructor)
    ParameterSet own;                                           ///< the type must know all of them
    /// defaults for parameters that are not given; those unknown to the type are dropped (pbrt's Attribute)
    std::vector<Parameter> fallbacks;
};

/// The result of a call, for other calls of the same builder; other builders refuse it. The values are private to the
/// builder. A default-constructed handle is the default material, which every builder accepts.
struct MaterialHandle {
    int reference = 0;          ///< by default the first material: diffuse, reflectance 0.5
    std::uint32_t builder = 0;  ///< the builder that returned it; 0: none
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

/// The place of a shape, and its material, light and media.
struct ShapePlacement {
    Transform to_world{};  ///< for a shape of an object: to the object's space
    /// The transform at the end of the motion, if the shape moves: it becomes an object of its own with one instance.
    /// If it is part of an object, every instance of that object places it too, by combined transforms.
    std::optional<Transform> moved_to{};
    MaterialHandle material{};
    AreaLightHandle area_light{};  ///< not for shapes of an object: instances do not emit (pbrt's rule)
    MediumHandle inside{}, outside{};
    bool reverse_orientation = false;
    ObjectHandle object{};  ///< the object that it is part of
    std::string label{};    ///< LPE object label; empty: the name of its material
};

/// A mesh without a file. Normals and texture coordinates: one per vertex, or none.
struct MeshData {
    std::vector<StoredVec3> positions;
    std::vector<std::uint32_t> indices;  ///< three per triangle; four per bilinear patch, p00 p10 p01 p11
    std::vector<StoredVec3> normals{};
    std::vector<StoredVec2> uvs{};
    bool patches = false;
};

/// Curves without a file that share material and type: cubic Bezier segments, 3 n + 1 points per curve.
struct CurveData {
    CurveType type = CurveType::flat;
    std::vector<StoredVec3> points;
    std::vector<std::uint32_t> first_points;  ///< of each curve
    std::vector<StoredVec2> widths;           ///< of each curve, at its start and its end
    std::vector<StoredVec3> normals{};        ///< for ribbons: n + 1 per curve
};

class SceneBuilder {
  public:
    /// `file` is the name of the scene in messages. Relative file names are searched in `search`, by default in the
    /// current folder.
    explicit SceneBuilder(std::string file, SearchPath search = {});
    // Not copyable: handles of the original would also be accepted by the copy, although the two differ.
    SceneBuilder(const SceneBuilder&) = delete;
    SceneBuilder& operator=(const SceneBuilder&) = delete;
    SceneBuilder(SceneBuilder&&) = default;
    SceneBuilder& operator=(SceneBuilder&&) = default;
    ~SceneBuilder() = default;
    void set_search(SearchPath search) { search_ = std::move(search); }
    /// Sets the treatment of missing files; by default they are errors.
    void set_missing_files(MissingFiles missing) { missing_ = missing; }

    // The last argument of each call is the position for messages, by default the calling source line.

    /// Sets the space of all colours in parameters and textures. Call it before adding any.
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
    /// Sets a camera that moves. `world_to_camera` and `moved_to` are transforms like those of Transform::look_at.
    Status set_moving_camera(const std::string& type, SceneParameters parameters, const Transform& world_to_camera,
                             const Transform& moved_to, MediumHandle medium = {},
                             const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// Sets the start and end times of all motion, in the units of the camera's "shutteropen" and "shutterclose"; the
    /// defaults are 0 and 1. math/animated_transform.h describes the interpolation.
    Status set_transform_times(double start, double end,
                               const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// Sets the camera. `world_to_camera` is a transform like those of Transform::look_at.
    Status set_camera(const std::string& type, SceneParameters parameters, const Transform& world_to_camera,
                      MediumHandle medium = {}, const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    Result<MaterialHandle> add_material(const std::string& type, SceneParameters parameters,
                                        const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Result<MaterialHandle> add_named_material(const SceneName& name, const std::string& type,
                                              SceneParameters parameters,
                                              const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// A material by name; it may be defined later.
    MaterialHandle material_named(const SceneName& name,
                                  const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// Adds a medium. `to_world` places the box of a grid.
    Result<MediumHandle> add_medium(const SceneName& name, const std::string& type, SceneParameters parameters,
                                    const Transform& to_world = {},
                                    const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// A medium by name; it may be defined later.
    MediumHandle medium_named(const SceneName& name,
                              const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// Adds a texture. `to_world` is the space of mappings other than uv. A texture may use those before it; materials
    /// use any.
    Status add_texture(const SceneName& name, TextureValue value, const std::string& type, SceneParameters parameters,
                       const Transform& to_world = {},
                       const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_light(const std::string& type, SceneParameters parameters, const Transform& to_world = {},
                     const std::string& group = {}, const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    /// Adds an area light; all shapes placed with it emit.
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
    /// An object by name; it may be defined later.
    ObjectHandle object_named(const SceneName& name,
                              const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_instance(ObjectHandle object, const Transform& to_world = {},
                        const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});
    Status add_moving_instance(ObjectHandle object, const Transform& to_world, const Transform& moved_to,
                               const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    /// Disables filtering of all images, whatever the "filter" of their textures.
    void disable_texture_filtering() { unfiltered_ = true; }
    /// Multiplies the "edgelength" of all displaced meshes by `factor`.
    Status scale_displacement_edges(double factor, const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

    /// Appends a warning of the scene's reader to SceneDescription::warnings.
    void warn(Error warning) { scene_.warnings.push_back(std::move(warning)); }

    /// Sets the number of threads that read meshes (0: all). `progress`, unless null, receives the numbers of meshes
    /// and of those read.
    void set_loading(int threads, LoadingProgress* progress) { threads_ = threads, progress_ = progress; }

    /// Reads mesh files, resolves names and returns the scene. Errors: a mesh that cannot be read, an undefined name
    /// that a shape, the camera or another entity uses. The builder accepts no calls afterwards, even if this one
    /// fails.
    Result<SceneDescription> finish(const SourceLocation& where = {__builtin_FILE(), __builtin_LINE()});

  private:
    struct Reference {
        int index = -1;  ///< -1: by name
        std::string name;
        SourceLocation location;
    };

    // scene_builder_handles.cpp
    /// Makes a handle to return from a call.
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
    /// `float_texture` is true for a texture of single numbers.
    Result<SceneEntity> make_entity(const std::string& type, EntityKind kind, SceneParameters parameters,
                                    const SourceLocation& where, bool float_texture = false);
    Result<ParameterSet> checked(const std::string& type, EntityKind kind, SceneParameters parameters,
                                 const SourceLocation& where, bool float_texture = false);
    Status resolve_files(ParameterSet& set) const;
    /// Resolves an entity's files, or replaces a missing one by a magenta constant, with a warning.
    Status resolve_entity(SceneEntity& entity, bool float_texture);
    void count_placeholder(const std::string& file, const SourceLocation& where);
    /// Adds a magenta box from -0.5 to 0.5 in place of a mesh whose file is missing.
    Status place_missing_mesh(const std::string& file, const ShapePlacement& placement, const SourceLocation& where);
    // scene_builder_shapes.cpp
    /// The list to which a shape is added: the scene's own, or an object's.
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

    /// A mesh file for read_meshes(), with the position of its shapes and warnings in the order of calls.
    struct NamedMesh {
        ParameterSet parameters;
        Transform to_world;
        ShapePlacement placement;
        SearchPath search;
        std::size_t shapes_before, warnings_before;
    };
    /// A shape that moves within the object whose reference is `object`; it is an object of its own.
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
