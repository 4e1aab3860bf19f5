// Connections of light subpaths to the camera, splatted where the camera sees their vertices.
#pragma once

#include <span>
#include <vector>

#include "display/services/samples/raster_splats.h"
#include "transport/cameras/camera.h"
#include "transport/paths/counters.h"
#include "transport/paths/record.h"
#include "transport/paths/strategies.h"
#include "transport/paths/subpath.h"

namespace raylex::transport {

/// Where the camera stands and what it fills.
struct CameraView {
    const Camera* camera = nullptr;
    int width = 0, height = 0;  ///< of the image
    Vec2 filter_radius;         ///< how far around the image light still counts, in pixels

    /// Density per area with which a camera ray through a raster position drawn evenly over the image meets a point
    /// whose raster area for each area is `importance`, |cosine| its own.
    [[nodiscard]] double density(Real importance, Real cosine) const {
        return static_cast<double>(importance) * static_cast<double>(cosine) /
               (static_cast<double>(width) * static_cast<double>(height));
    }
};

/// The vertex of a light subpath that is to be connected.
struct LightSubpathEnd {
    std::uint32_t row = 0;
    std::uint32_t depth = 0;  ///< scattering events before it
    VertexDepth length;
    const SurfacePoint* point = nullptr;
    const Bsdf* bsdf = nullptr;
    OffsetBound offset{};  ///< SurfaceSource::offset
    bool holdout = false;  ///< what the camera sees there is one
    Rgb power;
    LightEnd end;                        ///< its lobes are filled in here
    const StrategySums* sums = nullptr;  ///< null: this is the only strategy
    Real time = 0;                       ///< its subpath's
    std::uint32_t key = 0;               ///< of what its ray draws in grids; no matter where there are none
};

/// LightSubpathEnd::key of a vertex with so many scattering events before it.
inline std::uint32_t connection_key(const SceneView& scene, const PixelSampler& sampler, std::uint32_t depth) {
    if (!scene.media->any_grids()) return 0;
    return sampler.key(subpath_dimensions<TransportMode::importance>.connections + depth);
}

class CameraConnections {
  public:
    void clear() { pending_.clear(), shadow_rays_.clear(); }
    /// Whether the camera sees the point is found out by splat(). `lens` in [0, 1)^2.
    void add(const CameraView& view, const DepthLimit& limit, const LightSubpathEnd& end, const Vec2& lens);
    /// Leaves out what no channel accepts (Law 4): for renders without beauty, and without cutouts, whose events come
    /// before.
    void drop_dead(const Record& record, IntegratorCounters& counters);
    /// Adds all that are visible, and forgets them. `rows` say whose they are.
    void splat(const SceneView& scene, const EventTable& events, std::span<const display::CameraRow> rows,
               display::RasterSplats& raster, IntegratorCounters& counters);

  private:
    struct Pending {
        std::uint32_t row = 0;
        Real x = 0, y = 0;
        std::uint32_t light_vertices = 0;
        bool holdout = false;
        Rgb value, unweighted;
        std::uint32_t key = 0;
        LightEnd end;
        Ray from_camera;  ///< for cutouts, which come in the order in which its word reads them
    };
    std::vector<Pending> pending_;
    std::vector<Ray> shadow_rays_;
    std::vector<std::uint8_t> blocked_;
};

}  // namespace raylex::transport
