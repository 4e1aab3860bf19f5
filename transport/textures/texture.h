// Textures: constant, scale, mix, checkerboard, imagemap, and patterns (pattern.h), for floats and colours, evaluated
// by index.
//
// Patterns, mappings (uv, spherical, cylindrical, planar) and parameters are pbrt-v4's. Images are filtered over the
// footprint of a pixel (image_filter.h); patterns are evaluated at a point, without pbrt-v4's filtered checkerboard.
// The top of an image is at v = 1.
//
// A colour texture is compiled once for each role in which it is used (SpectrumRole): the role decides whether its
// values are clamped to [0, 1] and converted to the rendering space.
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

/// A point at which a texture is evaluated.
struct TexturePoint {
    Real u = 0, v = 0;
    Vec3 position;                                ///< in render space, the target of the texture's to_world
    Vec3 normal;                                  ///< unit, geometric, of either side; zero if unknown
    const SurfaceFootprint* footprint = nullptr;  ///< the footprint for filtering images; null: no filtering
    VertexServices services;                      ///< none in cutouts, which shadow rays evaluate too
};

class TextureTable {
  public:
    /// `space`: the space of TexturePoint::position. `threads` (0: all) read images; `progress`, unless null, is
    /// updated.
    static Result<TextureTable> build(const SceneDescription& scene, const RenderSpace& space = {}, int threads = 0,
                                      LoadingProgress* progress = nullptr);

    TextureTable();
    ~TextureTable();
    TextureTable(TextureTable&&) noexcept;
    TextureTable& operator=(TextureTable&&) noexcept;

    /// Warnings about images that had to be repaired.
    [[nodiscard]] const std::vector<Error>& warnings() const;
    /// Adds a warning about a texture's use.
    void warn(Error warning);

    [[nodiscard]] TextureId add_constant(const Rgb& value);
    /// Adds the texture first (1 - amount) + second amount. Returns an Error without a position if that needs too many
    /// look-ups.
    [[nodiscard]] Result<TextureId> add_mix(TextureId first, TextureId second, TextureId amount);
    /// The texture that a parameter names, or a constant from its value, or from `fallback` if it is absent.
    Result<TextureId> rgb_parameter(const ParameterSet& set, std::string_view name, const Rgb& fallback,
                                    SpectrumRole role, const ColorContext& color);
    Result<TextureId> real_parameter(const ParameterSet& set, std::string_view name, Real fallback);
    /// The first three channels of an image file as stored (tangent-space normals): bilinear, repeated.
    Result<TextureId> normal_map(const std::string& file, const SourceLocation& where);
    /// The float texture of this name (SceneShape::alpha_texture).
    Result<TextureId> named_real(std::string_view name, const SourceLocation& where) const;

    /// Whether the texture is constant and can be evaluated once.
    [[nodiscard]] bool is_constant(TextureId id) const;
    [[nodiscard]] Rgb rgb(TextureId id, const TexturePoint& at) const;
    [[nodiscard]] Real real(TextureId id, const TexturePoint& at) const;
    /// Whether any pattern uses look_ahead() (pattern.h).
    [[nodiscard]] bool looks_ahead() const;
    void look_ahead(std::span<const TexturePoint> points) const;

  private:
    struct Storage;
    std::unique_ptr<Storage> storage_;
};

}  // namespace raylex::transport
