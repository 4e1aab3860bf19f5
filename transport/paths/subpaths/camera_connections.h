// Connections of light subpaths to the camera, splatted where the camera sees their vertices.
#pragma once

#include <span>
#include <vector>

#include "transport/paths/counters.h"
#include "transport/paths/partial_mis_weights.h"
#include "transport/paths/path_context.h"
#include "transport/paths/path_depth.h"
#include "transport/paths/record.h"

namespace raylex::transport {

/// A vertex of a light subpath that is to be connected.
struct LightSubpathVertex {
    std::uint32_t row = 0;
    std::uint32_t depth = 0;  ///< scattering events before it
    VertexDepth length;
    OffsetBound offset{};         ///< SurfaceSource::offset
    bool holdout = false;         ///< the camera sees a holdout there
    bool one_wavelength = false;  ///< Subpath's
    bool weighted = false;  ///< other strategies exist: `mis_weights` gives the weight of multiple importance sampling
    Rgb power;              ///< Subpath::beta
    LightEnd end;           ///< without the lobes of the connection
    display::SuffixLiveness::LiveSet live;  ///< what a channel can still take of it
    PartialMisWeights mis_weights;
    Real time = 0;          ///< of its subpath's rays
    std::uint32_t key = 0;  ///< keys the numbers of its connection in grid media
};

/// Surfaces that the camera can see but to which light subpaths have no connection.
struct UnconnectedSurfaces {
    bool specular = false;  ///< mirrors and smooth glass have no density towards the camera
    bool curves = false;    ///< flat curves and tubes face the ray that meets them
};
UnconnectedSurfaces unconnected_surfaces(const SceneView& scene);

class CameraConnections {
  public:
    explicit CameraConnections(const PathContext& context) : context_(context) {}
    void clear() { pending_.clear(), shadow_rays_.clear(); }
    /// Connects a vertex at `point` with the lens, at a position from `sampler`. splat() tests visibility.
    /// `throughput`: Walk::throughput() of the vertex.
    void add(const LightSubpathVertex& vertex, const SurfacePoint& point, const Bsdf& bsdf, const Rgb& throughput,
             const DepthLimit& limit, const PixelSampler& sampler, IntegratorCounters& counters);
    /// Adds every visible connection to the image, and forgets all. `rows` are the camera rows of the batch.
    void splat(std::span<const display::CameraRow> rows, ThreadServices& services, IntegratorCounters& counters);

  private:
    void drop_dead(ThreadServices& services, IntegratorCounters& counters);

    struct Pending {
        std::uint32_t row = 0;
        Real x = 0, y = 0;
        std::uint32_t light_vertices = 0;
        bool holdout = false;
        Rgb value, unweighted;
        std::uint32_t key = 0;
        LightEnd end;
        Ray from_camera;  ///< for cutouts, which come in the order in which the path string reads them
    };
    const PathContext& context_;
    std::vector<Pending> pending_;
    std::vector<Ray> shadow_rays_;
    std::vector<std::uint8_t> blocked_;
};

}  // namespace raylex::transport
