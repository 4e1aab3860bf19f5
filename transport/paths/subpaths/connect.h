// Connections from camera subpaths to light: shadow rays in batches, with what cutouts and media on the way let
// through.
#pragma once

#include <span>
#include <vector>

#include "transport/paths/subpaths/camera_subpaths.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

/// A vertex of a camera subpath joined with one of a light subpath.
struct VertexJoin {
    std::size_t j = 0;                  ///< in the camera subpaths' vertices
    const BsdfEvaluation* f = nullptr;  ///< the scattering there
    Rgb unweighted;                     ///< that it brings to the camera if nothing is in between
    Real weight = 1;                    ///< of it, by multiple importance sampling
    LightEnd end;
    std::uint32_t light_vertices = 2;  ///< made from the light: s of its technique
    Ray shadow_ray;                    ///< from vertex j
};

class Connections {
  public:
    explicit Connections(const SceneView& scene)
        : scene_(scene), in_media_(scene.asks_for_media()), in_grids_(scene.media->any_grids()) {}
    void clear();

    /// A light sample, `f` being what its vertex scatters towards it: throughput x f x radiance x weight / pdf. Left
    /// out if nothing comes of it (Law 4).
    void add_light_sample(const CameraSubpaths& subpaths, std::size_t j, const LightSample& sample,
                          const BsdfEvaluation& f, Real weight);
    void add_join(const CameraSubpaths& subpaths, const VertexJoin& join);
    /// Traces all shadow rays, reports what arrives, and forgets it. Adds the rays that were left out to
    /// Pruned::shadow_rays.
    void report(CameraSubpaths& subpaths);

  private:
    static constexpr std::uint32_t no_end = 0xffffffffu, no_light = 0xffffffffu;
    struct Pending {
        std::uint32_t row, light;    // light: of a light sample
        std::int32_t label, medium;  // medium: in which the shadow ray begins
        std::uint32_t end;           // in ends_
        display::Technique technique;
        Rgb value;
        LobeList lobes;
    };
    struct Blockable {
        Rgb emitted, unweighted;
    };
    /// Whether the last of pending_ is to be traced; it is reported or dropped if not.
    bool is_worth_a_ray(const Record& record);
    void report_one(const Record& record, std::size_t i, Arrival& arrival, display::Tracker& tracker) const;

    const SceneView scene_;
    const bool in_media_, in_grids_;
    std::vector<Pending> pending_;
    std::vector<Blockable> blockable_;  // beside pending_, where blocked light counts
    std::vector<LightEnd> ends_;
    std::vector<Ray> shadow_rays_;
    std::vector<std::uint8_t> blocked_;
    std::uint64_t not_worth_ = 0;  // shadow rays since the last report
};

}  // namespace raylex::transport
