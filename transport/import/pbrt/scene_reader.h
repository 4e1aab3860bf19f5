// Turns directives into calls of a SceneBuilder: the graphics state of pbrt's scene files.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "transport/files/input_file.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/import/known_parameters.h"
#include "transport/import/pbrt/graphics_state.h"
#include "transport/import/pbrt/parser.h"

namespace raylex::transport {

class SceneReader {
  public:
    SceneReader(std::string file, MissingFiles missing, int threads, LoadingProgress* progress)
        : scene_(std::move(file)) {
        scene_.set_missing_files(missing);
        scene_.set_loading(threads, progress);
    }

    /// Sets the search path for files of later directives.
    void set_search(SearchPath search) { scene_.set_search(std::move(search)); }
    /// Executes one directive other than Include and Import.
    Status apply(Directive& directive);

    /// Enters an imported file: its changes of the graphics state and of coordinate systems end with it.
    Status begin_import(const Directive& directive);
    Status end_import();

    /// Resolves names and returns the scene. A missing WorldBegin is reported at `file_end`.
    Result<SceneDescription> finish(const SourceLocation& file_end);

  private:
    enum class Block : std::uint8_t { attribute, object, import };
    struct Saved {
        Block block;
        GraphicsState state;
        SourceLocation opened;
        std::map<std::string, std::array<Transform, 2>> coordinate_systems;  // for Import only
    };

    // scene_reader.cpp
    Status require_block(const Directive& directive) const;
    Status begin_block(Block block, const SourceLocation& where);
    Status end_block(Block block, const Directive& directive);
    Status world_begin(const Directive& directive);
    Status color_space(const Directive& directive);
    Status medium_interface(const Directive& directive);
    Status option(const Directive& directive);
    Status attribute(Directive& directive);
    Status accelerator(Directive& directive);
    Status settings(Directive& directive);
    Status camera(Directive& directive);
    // scene_reader_transforms.cpp
    Status transform(const Directive& directive);
    Status active_transform(const Directive& directive);
    Status concatenate(const Transform& transform);
    [[nodiscard]] bool moves() const { return state_.ctm[0].matrix() != state_.ctm[1].matrix(); }
    const Transform& first_transform(const char* what, const SourceLocation& where);
    // scene_reader_world.cpp
    Status world_entity(Directive& directive);
    Status material(Directive& directive);
    Status named_material(Directive& directive);
    Status named_medium(Directive& directive);
    Status texture(Directive& directive);
    Status light(Directive& directive);
    Status area_light(Directive& directive);
    Status shape(Directive& directive);
    Status object_begin(const Directive& directive);
    Status instance(const Directive& directive);
    [[nodiscard]] SceneParameters with_defaults(Directive& directive, const char* target, bool light) const;
    [[nodiscard]] SceneParameters light_parameters(Directive& directive) const;

    SceneBuilder scene_;
    ParameterChecker accelerators_;
    GraphicsState state_;
    std::vector<Saved> stack_;
    std::map<std::string, std::array<Transform, 2>> coordinate_systems_;
    ObjectHandle active_object_;
    bool in_world_ = false;
};

/// Converts rgb parameters of `set` from one colour space to another: lights keep their colour, other parameters keep
/// white white. Indices of refraction and coefficients (eta, k, sigma_a, sigma_s) are not colours and stay unchanged.
void convert_colors(ParameterSet& set, ColorSpace to, ColorSpace from, bool light);

}  // namespace raylex::transport
