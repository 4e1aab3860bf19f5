// Connections from camera subpaths to light: shadow rays in batches, attenuated by cutouts and media on the way.
#pragma once

#include <span>
#include <vector>

#include "transport/paths/subpaths/camera_subpaths.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

/// A vertex of a camera subpath connected with one of a light subpath.
struct VertexConnection {
    std::size_t j = 0;                  ///< index into the vertices of the camera subpaths
    const BsdfEvaluation* f = nullptr;  ///< the scattering there
    Rgb unweighted{};                   ///< contribution if nothing is in between, before `weight`
    Real weight = 1;                    ///< of multiple importance sampling
    LightEnd end{};
    std::uint32_t light_vertices = 2;  ///< s: number of vertices made from the light
    Ray shadow_ray{};                  ///< from vertex j
};

class Connections {
  public:
    explicit Connections(const SceneView& scene)
        : scene_(scene), in_media_(scene.asks_for_media()), in_grids_(scene.media->any_grids()) {}
    void clear();

    /// Adds a light sample: throughput x f x radiance x weight / pdf. `f`: the scattering of vertex j towards the
    /// light. Left out if no channel takes it (Law 4).
    void add_light_sample(const CameraSubpaths& subpaths, std::size_t j, const LightSample& sample,
                          const BsdfEvaluation& f, Real weight);
    void add_connection(const CameraSubpaths& subpaths, const VertexConnection& connection);
    /// Traces all shadow rays, reports the light that arrives, and forgets the connections. Adds the rays that were
    /// left out to Pruned::shadow_rays.
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
    /// Whether to trace a ray for the last of pending_. If not, it was reported or dropped.
    bool needs_shadow_ray(const Record& record);
    void report_one(const Record& record, std::size_t i, Arrival& arrival, display::Tracker& tracker) const;

    const SceneView scene_;
    const bool in_media_, in_grids_;
    std::vector<Pending> pending_;
    std::vector<Blockable> blockable_;  // beside pending_, where blocked light counts
    std::vector<LightEnd> ends_;
    std::vector<Ray> shadow_rays_;
    std::vector<std::uint8_t> blocked_;
    std::uint64_t rays_left_out_ = 0;  // since the last report
};

}  // namespace raylex::transport
