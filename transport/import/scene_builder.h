// Directives into a SceneDescription: the state machine behind pbrt's scene files.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "transport/import/graphics_state.h"
#include "transport/import/input_file.h"
#include "transport/import/known_parameters.h"
#include "transport/import/parser.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

class SceneBuilder {
  public:
    explicit SceneBuilder(std::string file);

    /// Carries out one directive other than Include and Import.
    Status apply(Directive& directive, const SearchPath& search);

    /// Around an imported file: what it does to the graphics state and to coordinate systems ends with it.
    Status begin_import(const Directive& directive);
    Status end_import();

    /// Resolves names and hands over the scene. `file_end` is where a missing WorldBegin is reported.
    Result<SceneDescription> finish(const SourceLocation& file_end);

  private:
    enum class Block : std::uint8_t { attribute, object, import };
    struct Saved {
        Block block;
        GraphicsState state;
        SourceLocation opened;
        std::map<std::string, std::array<Transform, 2>> coordinate_systems;  // import only
    };
    struct MaterialReference {
        int index = -1;  // into materials; -1: by name
        std::string name;
        SourceLocation location;
    };
    struct InstanceReference {
        std::string name;
        SourceLocation location;
    };

    // scene_builder.cpp
    Status require_block(const Directive& directive) const;
    Status begin_block(Block block, const SourceLocation& where);
    Status end_block(Block block, const Directive& directive);
    Status world_begin(const Directive& directive);
    Status color_space(const Directive& directive);
    Status medium_interface(const Directive& directive);
    Status option(const Directive& directive);
    Status attribute(Directive& directive);
    Status accelerator(const Directive& directive);
    Status settings(Directive& directive);
    Status camera(Directive& directive);
    // scene_builder_transforms.cpp
    Status transform(const Directive& directive);
    Status active_transform(const Directive& directive);
    Status concatenate(const Transform& transform, const SourceLocation& where);
    Status check_invertible(const SourceLocation& where) const;
    Result<Transform> still_transform(const SourceLocation& where) const;
    // scene_builder_world.cpp
    Status world_entity(Directive& directive, const SearchPath& search);
    Status material(Directive& directive, const SearchPath& search);
    Status named_material(Directive& directive, const SearchPath& search);
    Status named_medium(Directive& directive, const SearchPath& search);
    Status texture(Directive& directive, const SearchPath& search);
    Status light(Directive& directive, const SearchPath& search);
    Status area_light(Directive& directive, const SearchPath& search);
    Status shape(Directive& directive, const SearchPath& search);
    Status object_begin(const Directive& directive);
    Status instance(const Directive& directive);
    Result<SceneEntity> make_entity(Directive& directive, std::string type, EntityKind kind, const SearchPath& search);
    Status resolve_files(ParameterSet& set, const SearchPath& search) const;
    // scene_builder_names.cpp
    Status resolve_materials();
    Status resolve_instances();
    Status check_textures() const;
    Status check_shape(const SceneShape& shape) const;
    [[nodiscard]] bool has_texture(const std::string& name, bool spectrum, bool any_kind, std::size_t before) const;
    Error no_such_texture(const std::string& name, const SourceLocation& where, const char* kind) const;

    SceneDescription scene_;
    ParameterChecker parameters_;
    GraphicsState state_;
    std::vector<Saved> stack_;
    std::map<std::string, std::array<Transform, 2>> coordinate_systems_;
    std::vector<MaterialReference> material_references_;
    std::vector<InstanceReference> instance_references_;  // parallel to scene_.instances
    std::map<std::string, int> named_materials_;
    std::map<std::string, std::size_t> named_textures_[2];  // float, spectrum
    std::set<std::string> object_names_;
    std::map<std::string, int> named_media_;
    int active_object_ = -1;
    bool in_world_ = false;
};

/// rgb parameters of `set` from one colour space to another: lights keep their colour, all else keeps white white.
/// Indices of refraction and coefficients (eta, k, sigma_a, sigma_s) are no colours and stay.
void convert_colors(ParameterSet& set, ColorSpace to, ColorSpace from, bool light);

}  // namespace raylex::transport
