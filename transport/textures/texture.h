// Textures: constant, scale, mix, checkerboard, imagemap, and patterns (pattern.h); float and colour alike, evaluated
// by index.
//
// Patterns, mappings (uv, spherical, cylindrical, planar) and parameters are pbrt-v4's. Images are filtered over what a
// pixel sees of the surface (image_filter.h); patterns are looked up at a point, without pbrt-v4's filtered
// checkerboard. The top of an image is at v = 1.
//
// A colour texture is compiled once for every role it is used in (SpectrumRole): the role decides whether its values
// are clamped to [0, 1] and taken to the rendering space.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "display/services/registry.h"
#include "transport/color/spectrum.h"
#include "transport/geometry/render_space.h"
#include "transport/geometry/surface_point.h"
#include "transport/math/real.h"
#include "transport/scene/loading_progress.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Index of a texture; constants are textures too.
using TextureId = std::int32_t;

/// Where a texture is looked up.
struct TexturePoint {
    Real u = 0, v = 0;
    Vec3 position;                                ///< render space, where the texture's own to_world leads too
    Vec3 normal;                                  ///< unit, geometric, either side; zero where it is not known
    const SurfaceFootprint* footprint = nullptr;  ///< what images are filtered over; null: nothing
    VertexServices services;                      ///< none in cutouts, which shadow rays meet too
};

class TextureTable {
  public:
    /// `space`: where TexturePoint::position stands. `threads` (0: all) read images; `progress`, if any, is told.
    static Result<TextureTable> build(const SceneDescription& scene, const RenderSpace& space = {}, int threads = 0,
                                      LoadingProgress* progress = nullptr);

    TextureTable();
    ~TextureTable();
    TextureTable(TextureTable&&) noexcept;
    TextureTable& operator=(TextureTable&&) noexcept;

    /// What was wrong with images that were read and could be mended.
    [[nodiscard]] const std::vector<Error>& warnings() const;
    /// What is said with them, of a texture's use.
    void warn(Error warning);

    [[nodiscard]] TextureId add_constant(const Rgb& value);
    /// first (1 - amount) + second amount. An Error without a place where that looks up too many textures.
    [[nodiscard]] Result<TextureId> add_mix(TextureId first, TextureId second, TextureId amount);
    /// The texture behind a "texture"-typed parameter, or a constant from its value, or from `fallback` when absent.
    Result<TextureId> rgb_parameter(const ParameterSet& set, std::string_view name, const Rgb& fallback,
                                    SpectrumRole role, const ColorContext& color);
    Result<TextureId> real_parameter(const ParameterSet& set, std::string_view name, Real fallback);
    /// The first three channels of an image file as they are stored (tangent-space normals): bilinear, repeated.
    Result<TextureId> normal_map(const std::string& file, const SourceLocation& where);
    /// By the float texture's own name (SceneShape::alpha_texture).
    Result<TextureId> named_real(std::string_view name, const SourceLocation& where) const;

    /// The same value everywhere: read it once.
    [[nodiscard]] bool is_constant(TextureId id) const;
    [[nodiscard]] Rgb rgb(TextureId id, const TexturePoint& at) const;
    [[nodiscard]] Real real(TextureId id, const TexturePoint& at) const;
    /// Whether any pattern wants look_ahead() (pattern.h).
    [[nodiscard]] bool looks_ahead() const;
    void look_ahead(std::span<const TexturePoint> points) const;

  private:
    struct Storage;
    std::unique_ptr<Storage> storage_;
};

}  // namespace raylex::transport
