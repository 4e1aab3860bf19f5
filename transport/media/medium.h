// Participating media: plain values and the three things that paths ask of them.
//
// In homogeneous media transmittance and emission along a segment have closed forms; chance decides only how far a path
// flies. Others hold a grid (grid_medium.h), which is asked instead. Where colours have different extinction, one
// colour picked in proportion to the path's throughput draws the distance, and the weight divides by the mean density
// over all colours (the balance heuristic over the three strategies): every colour is unbiased, none is weighed by more
// than its share of the throughput.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "display/services/registry.h"
#include "lpe/result.h"
#include "transport/geometry/render_space.h"
#include "transport/media/grid_medium.h"

namespace raylex::transport {

/// Coefficients per unit of world length, in the rendering space.
struct Medium {
    Rgb sigma_a, sigma_s, sigma_t;
    Rgb emission;           ///< radiance added per unit length: sigma_a Le
    Real g = 0;             ///< Henyey-Greenstein asymmetry
    bool grey = true;       ///< sigma_t is the same in all colours
    bool scatters = false;  ///< sigma_s is not black
    bool emits = false;
    std::shared_ptr<const GridMedium>
        grid;              ///< what it is from place to place; the coefficients above mean nothing then
    bool in_body = false;  ///< inside a subsurface material, for what "maxdepth" counts (path_depth.h)
};

/// exp(-sigma_t distance). Colours without extinction pass whole, over an infinite distance too.
Rgb transmittance(const Medium& medium, Real distance);

/// Radiance that the medium emits along a segment towards its beginning.
Rgb emission_along(const Medium& medium, Real distance);

/// Samples a collision in front of `end` (infinity allowed). `throughput` decides the odds of the colours; it must not
/// be black. u in [0, 1)^2. Segments of an optical depth below 2^-16 collide with that chance, whatever their depth.
FreeFlight sample_free_flight(const Medium& medium, const Rgb& throughput, Real end, const Vec2& u);

/// Where a medium that only absorbs takes light away on a segment of length `end`: a distance whose density is the mean
/// over the colours of what they lose there. For deep images.
Real sample_absorption(const Medium& medium, Real end, const Vec2& u);

/// The radiance that a path through the medium may meet, about, where paths are `length` long.
Rgb brightest_glow(const Medium& medium, Real length);

struct MediumContext {
    const SceneDescription& scene;
    const RenderSpace* space = nullptr;  ///< null: what words need is enough (scatters, emits), no grids are read
    std::vector<Error>& warnings;
};
using MediumFactory = std::function<Result<Medium>(const SceneMedium&, const MediumContext&)>;
/// homogeneous, uniformgrid, rgbgrid, cloud, nanovdb.
Registry<MediumFactory>& medium_registry();

/// The media that a scene's shapes and camera refer to, under their index in SceneDescription::media. Immutable.
class MediumTable {
  public:
    /// Media that nothing refers to are left as vacuum and not checked: pbrt scenes keep them around. `space` as in
    /// MediumContext.
    static Result<MediumTable> build(const SceneDescription& scene, std::vector<Error>& warnings,
                                     const RenderSpace* space = nullptr);

    /// One more, as `name`; its index.
    std::int32_t add(const Medium& medium, const std::string& name);
    /// Whether anything refers to a medium: without, paths go on as if there were no such thing.
    [[nodiscard]] bool any() const { return any_; }
    /// Whether a ray that hits nothing can meet light all the same.
    [[nodiscard]] bool any_emits() const { return any_emits_; }
    /// Whether any differs from place to place: shadow rays then draw numbers.
    [[nodiscard]] bool any_grids() const { return any_grids_; }
    [[nodiscard]] std::size_t grid_bytes() const;
    [[nodiscard]] const Medium& operator[](std::int32_t index) const { return media_[static_cast<std::size_t>(index)]; }
    [[nodiscard]] std::size_t size() const { return media_.size(); }
    /// What events call the medium: its name in the scene.
    [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
    /// Whether any is inside a subsurface material.
    [[nodiscard]] bool any_bodies() const { return any_bodies_; }
    /// The medium that the camera stands in; -1: none.
    [[nodiscard]] std::int32_t camera() const { return camera_; }

  private:
    std::vector<Medium> media_;
    std::vector<std::string> names_;
    std::int32_t camera_ = -1;
    bool any_ = false, any_emits_ = false, any_grids_ = false, any_bodies_ = false;
};

}  // namespace raylex::transport
