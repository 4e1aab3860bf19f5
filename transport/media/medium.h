// Participating media: plain values, and the three operations that paths need.
//
// In homogeneous media, transmittance and emission along a segment have closed forms; only the distance of a path is
// random. Other media contain a grid (grid_medium.h), which computes these instead. If colours have different
// extinction, one colour, picked in proportion to the path's throughput, draws the distance, and the weight divides by
// the mean density over all colours (the balance heuristic over the three strategies): every colour is unbiased, and no
// weight exceeds the colour's share of the throughput.
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
    bool grey = true;       ///< sigma_t is equal in all colours
    bool scatters = false;  ///< sigma_s is not black
    bool emits = false;
    std::shared_ptr<const GridMedium> grid;  ///< the medium of each place; the coefficients above are unused then
    bool in_body = false;  ///< inside a subsurface material, for the depth that "maxdepth" limits (path_depth.h)
};

/// The transmittance exp(-sigma_t distance). Without extinction it is 1, over an infinite distance too.
Rgb transmittance(const Medium& medium, Real distance);

/// Radiance that the medium emits along a segment towards its beginning.
Rgb emission_along(const Medium& medium, Real distance);

/// Samples a collision before `end` (infinity allowed). `throughput` sets the probabilities of the colours and must not
/// be black. u in [0, 1)^2. Segments of an optical depth below 2^-16 collide with that probability, whatever their
/// depth.
FreeFlight sample_free_flight(const Medium& medium, const Rgb& throughput, Real end, const Vec2& u);

/// Samples the distance at which a medium that only absorbs attenuates a segment of length `end`, with the mean over
/// the colours of the attenuation as density. For deep images.
Real sample_absorption(const Medium& medium, Real end, const Vec2& u);

/// The approximate radiance that a path of `length` through the medium may collect.
Rgb brightest_glow(const Medium& medium, Real length);

struct MediumContext {
    const SceneDescription& scene;
    const RenderSpace* space = nullptr;  ///< null: only `scatters` and `emits` are needed, and no grids are read
    std::vector<Error>& warnings;
};
using MediumFactory = std::function<Result<Medium>(const SceneMedium&, const MediumContext&)>;
/// The registered media: homogeneous, uniformgrid, rgbgrid, cloud, nanovdb.
Registry<MediumFactory>& medium_registry();

/// The media to which a scene's shapes and camera refer, by their index in SceneDescription::media. Immutable.
class MediumTable {
  public:
    /// Media to which nothing refers become vacuum and are not checked, since pbrt scenes often contain some. `space`
    /// is that of MediumContext.
    static Result<MediumTable> build(const SceneDescription& scene, std::vector<Error>& warnings,
                                     const RenderSpace* space = nullptr);

    /// Adds a medium called `name`; returns its index.
    std::int32_t add(const Medium& medium, const std::string& name);
    /// Whether anything refers to a medium; if not, paths skip all code for media.
    [[nodiscard]] bool any() const { return any_; }
    /// Whether any medium emits, so that a ray that hits nothing can still collect light.
    [[nodiscard]] bool any_emits() const { return any_emits_; }
    /// Whether any medium is heterogeneous: shadow rays then draw random numbers.
    [[nodiscard]] bool any_grids() const { return any_grids_; }
    [[nodiscard]] std::size_t grid_bytes() const;
    [[nodiscard]] const Medium& operator[](std::int32_t index) const { return media_[static_cast<std::size_t>(index)]; }
    [[nodiscard]] std::size_t size() const { return media_.size(); }
    /// The names of the media in the scene, which events use.
    [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
    /// Whether any medium is inside a subsurface material.
    [[nodiscard]] bool any_bodies() const { return any_bodies_; }
    /// The medium around the camera; -1: none.
    [[nodiscard]] std::int32_t camera() const { return camera_; }

  private:
    std::vector<Medium> media_;
    std::vector<std::string> names_;
    std::int32_t camera_ = -1;
    bool any_ = false, any_emits_ = false, any_grids_ = false, any_bodies_ = false;
};

}  // namespace raylex::transport
