// Subpaths from the camera, one a row, side by side: a walk that begins with camera rays, writes distance, opacity,
// surface and geometric AOVs of first hits, reports the user events of surfaces, and splits paths where the plan of the
// render does. An integrator adds the light that the subpaths meet.
//
//     camera.begin(batch, services, counters);
//     while (camera.advance(services)) {
//         ...                              // escaped(), emitters(), vertices()
//         camera.scatter();
//     }
#pragma once

#include <memory>
#include <vector>

#include "transport/paths/first_hits.h"
#include "transport/paths/plan/splits.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

/// The time of a sample's rays, its camera subpath's and its light subpath's; 0 where nothing moves.
inline Real sample_time(const SceneView& scene, const PixelSampler& sampler) {
    if (!scene.asks_for_times()) return 0;
    return static_cast<Real>(scene.geometry->shutter().time_of(static_cast<double>(sampler.get_1d(time_dimension))));
}

class CameraSubpaths : public Walk<TransportMode::radiance> {
  public:
    /// `context` must outlive the subpaths.
    CameraSubpaths(const PathContext& context, WalkOptions options);

    void begin(const CameraBatch& batch, ThreadServices& services, IntegratorCounters& counters);
    /// Traces one ray of each subpath. False: no subpath goes on, or services.leaving().
    bool advance(ThreadServices& services);
    void scatter();

    /// Sets among which lights (Subpath::lights) and with which techniques the row's subpath looks for light from its
    /// vertex.
    void choose_techniques(std::uint32_t row, std::uint8_t lights, const TechniqueShares& shares) {
        paths_[row].lights = lights;
        if (!shares_.empty()) shares_[row] = shares;
    }
    /// The expected number of rays that leave vertex j in directions with a density and compete with light samples. 1
    /// at closures whose mean depends on the weights.
    [[nodiscard]] Real expected_rays(std::size_t j) const {
        if (splits_.empty() && shares_.empty()) return 1;
        if (vertices().bsdfs[j].depends_on_weights()) return 1;
        const std::uint32_t row = vertices().rows[j];
        const Real rays = splits_.empty() ? 1 : splits_[row].expected;
        return shares_.empty() ? rays : shares_[row].ray * rays;
    }
    /// Draws the numbers of light samples of all vertices; pair(j) returns them.
    void draw_light_pairs() { draw_pairs(light_sample_dimension); }
    /// Whether vertex j can be connected with light: its closure has a density, and a path one event longer is not too
    /// long. In bodies the length depends on the direction: call the second overload as well.
    [[nodiscard]] bool can_connect(std::size_t j) const { return vertices().bsdfs[j].has_density() && may_scatter(j); }
    [[nodiscard]] bool can_connect(std::size_t j, const Vec3& direction) const {
        if (!depth_limit().has_bodies()) return true;
        const VertexDepth vertex = vertex_depth(j);
        return depth_limit().allows(vertex.before + depth_limit().event(vertex, vertices().points[j], direction));
    }
    /// Whether a channel takes light that connections of vertex j may bring (Law 4).
    [[nodiscard]] bool needs_connections(std::size_t j) const {
        const VertexBatch& v = vertices();
        return record_.is_live(v.rows[j], v.sources[j].label, v.points[j].material);
    }
    /// Reports light that the subpath of a row has met: throughput x emitted x weight. `sampled_too`: a light sample
    /// could have found it as well (Arrival::sampled_too).
    void report(std::uint32_t row, std::uint32_t light, const Rgb& throughput, const Rgb& emitted, Real weight,
                bool sampled_too) const {
        const Rgb value = throughput * emitted;
        record_.arrive(row, record_.events().terminal(light), {0, path(row).depth + 2},
                       {.value = value * weight, .emitted = emitted, .unweighted = value, .sampled_too = sampled_too});
    }

  private:
    void split(std::size_t j);
    void choose_rays(std::size_t j);
    void keep_split_vertices();
    /// Sends subpaths back to vertices that were kept for further branches. Call it when no subpath goes on. Returns
    /// false if no vertex is left.
    bool go_back();
    void report_surfaces();
    void keep_live_lobes();

    const bool planned_;     // the plan changes which rays go on
    const bool live_lobes_;  // interfaces sample only the side that some channel takes
    geoaovs::ShadingBatch first_hits_;
    // Where paths may be split.
    std::vector<PixelSampler> branch_samplers_;           // by row
    std::vector<std::unique_ptr<SplitVertices>> levels_;  // a stack: the newest is finished first
    std::size_t levels_in_use_ = 0;
};

}  // namespace raylex::transport
