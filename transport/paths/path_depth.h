// How long a path is for "maxdepth".
//
// An event is a scattering. Inside bodies of subsurface materials paths scatter hundreds of times where pbrt looks up
// one event in a table, so rays there do not count: a scattering is one half for each ray beside it that is not inside
// a body. Events elsewhere are whole ones, ways in and out halves, and what happens within is nothing - but for
// reflections at a body's surface from within, which are 1/1024 each, since total reflection in a clear body has no
// end; 511 are free. This is of the path and not of where it began, so that all strategies count alike, those that
// join subpaths too, whatever way (through holes, say) rays took into a body.
#pragma once

#include <cstdint>

#include "transport/geometry/surface_point.h"
#include "transport/media/medium.h"

namespace raylex::transport {

/// Lengths are in 1/1024 of an event.
inline constexpr std::int32_t whole_event = 1024;

/// A vertex from which a path may go on or be joined: how long the path is that leads there, and what is around.
struct VertexDepth {
    std::int32_t before = 0;  ///< length of its subpath,
    std::int32_t least = 0;   ///< and with the least that an event there may count
    bool surface = false;
    bool came_within = false;                        ///< the subpath came through a body,
    bool front_within = false, back_within = false;  ///< and on the side of the geometric normal or on the other is one
};

class DepthLimit {
  public:
    /// max_depth: at most 10^6. Nothing scatters at 0, inside bodies neither.
    DepthLimit(const MediumTable& media, std::uint32_t max_depth)
        : has_bodies_(media.any_bodies()),
          longest_(max_depth == 0
                       ? -1
                       : static_cast<std::int32_t>(max_depth) * whole_event + (has_bodies_ ? whole_event / 2 - 1 : 0)) {
    }

    [[nodiscard]] bool has_bodies() const { return has_bodies_; }
    [[nodiscard]] bool allows(std::int32_t length) const { return length <= longest_; }
    /// The least that an event counts behind a ray that came through a body or not.
    [[nodiscard]] std::int32_t least(bool came_within) const {
        if (!has_bodies_) return whole_event;
        return came_within ? 0 : whole_event / 2;
    }
    /// What it counts for a path that goes on in this direction.
    [[nodiscard]] std::int32_t event(const VertexDepth& vertex, const SurfacePoint& point,
                                     const Vec3& direction) const {
        if (!has_bodies_) return whole_event;
        const bool goes_within = dot(direction, point.geometric_normal) > 0 ? vertex.front_within : vertex.back_within;
        const std::int32_t outside = (vertex.came_within ? 0 : 1) + (goes_within ? 0 : 1);
        return outside == 0 && vertex.surface ? 1 : outside * (whole_event / 2);
    }

  private:
    bool has_bodies_;
    std::int32_t longest_;
};

}  // namespace raylex::transport
