// Subpaths from the lights, one a row, side by side: a light and a ray leaving it are drawn by emitted power, then the
// ray goes from vertex to vertex.
//
//     light.begin(batch, services, counters);
//     while (light.advance(services)) {
//         ...                          // vertices()
//         light.scatter();
//     }
#pragma once

#include <memory>
#include <vector>

#include "transport/paths/subpaths/camera_connections.h"
#include "transport/paths/subpaths/camera_subpaths.h"

namespace raylex::transport {

/// The lights from which light subpaths begin, for a whole render: the lights whose light some channel can take.
class LightEmitters {
  public:
    LightEmitters() = default;
    /// `max_depth`: scattering events of a path.
    LightEmitters(const PathContext& context, std::uint32_t max_depth);

    /// Null when no channel reads path strings.
    [[nodiscard]] const LightLanguage* language() const { return language_.get(); }
    [[nodiscard]] const LightChooser& chooser() const { return chooser_; }
    /// [light] The medium in which a ray leaves it; empty without media.
    [[nodiscard]] std::span<const std::int32_t> media() const { return media_; }
    /// Whether any subpath begins.
    [[nodiscard]] bool any() const { return any_; }
    /// Whether the scene has lights for light subpaths, but no channel takes their light.
    [[nodiscard]] bool none_is_live() const { return none_is_live_; }

  private:
    std::shared_ptr<const LightLanguage> language_;
    LightChooser chooser_;
    std::vector<std::int32_t> media_;
    bool any_ = false, none_is_live_ = false;
};

class LightSubpaths : public Walk<TransportMode::importance> {
  public:
    /// `context` and `emitters` must outlive the subpaths.
    LightSubpaths(const PathContext& context, const LightEmitters& emitters, const WalkOptions& options);

    /// Begins one subpath for each camera ray, at its time. LightEnds of the batch before become invalid.
    void begin(const CameraBatch& batch, ThreadServices& services, IntegratorCounters& counters);
    /// Traces one ray of each subpath. False: no subpath goes on, or services.leaving().
    bool advance(ThreadServices& services);

    /// Vertex j, to be connected with the camera or with camera subpaths. Points into vertices().
    [[nodiscard]] LightSubpathVertex vertex(std::size_t j) const;
    /// Whether a channel takes a connection of the camera's vertex j with `vertex`, which has this material. Counts
    /// connections that are left out.
    [[nodiscard]] bool may_connect(CameraSubpaths& camera, std::size_t j, const LightSubpathVertex& vertex,
                                   std::int32_t material) const {
        const VertexBatch& v = camera.vertices();
        if (record_.is_live_connection(camera.record(), v.rows[j], v.sources[j].label, v.points[j].material, vertex.end,
                                       material))
            return true;
        camera.counters().count(Pruned::connections);
        return false;
    }

  private:
    void start(std::uint32_t row, const EmissionSample& sample, Real time);
    [[nodiscard]] Rgb from_infinity(std::uint32_t row, const EmissionSample& sample) const;

    const LightEmitters& emitters_;
};

}  // namespace raylex::transport
