// The length of a path, which "maxdepth" limits.
//
// A scattering is an event of length 1, except in bodies of subsurface materials. There a path scatters hundreds of
// times where pbrt looks up one event in a table. So a scattering in the medium of a body has length 0, a passage
// through its surface 1/2, and a reflection at its surface from within 1/64. A path can have 31 such reflections
// without reaching a further event. They cover all but 10^-7 of the light (a body of eta 1.5 keeps 0.6 of the light
// that reaches its surface from within), and total reflection, which may never end, is bounded. Things inside a body
// have events of length 1.
//
// The length of a scattering follows from its surface (or the medium around it) and its two directions, never from
// earlier vertices. So all strategies compute the same length, connections included, also in bodies that have holes or
// are inside out. The medium of such a body may fill all of space. A walk in it never ends if the medium absorbs
// nothing, so a subpath has at most 65,536 scatterings, or "maxdepth" if that is more. By then 99.6 % of the light has
// left a half space that absorbs nothing: after n steps of any symmetric distribution, the first of them inwards, 2 /
// sqrt(pi n) is left (Sparre Andersen 1954; reflection at the surface is ignored).
#pragma once

#include <cstdint>

#include "transport/embree/embree_scene.h"
#include "transport/geometry/surface_point.h"
#include "transport/media/medium.h"

namespace raylex::transport {

/// Lengths are in 1/64 of an event.
inline constexpr std::int32_t whole_event = 64;

/// A vertex from which a path may continue or be connected: the length of the path to the vertex, and which of its
/// sides are inside a body.
struct VertexDepth {
    std::int32_t before = 0;  ///< length of its subpath
    std::int32_t least = 0;   ///< `before` plus the least that an event there may count
    bool on_body = false;     ///< on a body's surface or in its medium. Elsewhere events are whole
    bool collision = false;
    bool came_within = false;                        ///< the subpath came from within the body
    bool front_within = false, back_within = false;  ///< where the geometric normal points, and the other side
};

class DepthLimit {
  public:
    /// max_depth: at most 10^6. At 0 nothing scatters, not even inside bodies.
    DepthLimit(const MediumTable& media, std::uint32_t max_depth)
        : media_(media),
          has_bodies_(media.any_bodies()),
          longest_(max_depth == 0
                       ? -1
                       : static_cast<std::int32_t>(max_depth) * whole_event + (has_bodies_ ? whole_event / 2 - 1 : 0)),
          longest_walk_(max_depth > 65536 ? max_depth : 65536) {}

    [[nodiscard]] bool has_bodies() const { return has_bodies_; }
    [[nodiscard]] bool allows(std::int32_t length) const { return length <= longest_; }
    /// In scenes with bodies: whether a subpath with this number of scatterings may have one more.
    [[nodiscard]] bool allows_walk(std::uint32_t scatterings) const { return scatterings < longest_walk_; }
    [[nodiscard]] bool is_within(std::int32_t medium) const { return medium >= 0 && media_[medium].in_body; }

    /// A vertex behind a path of this length: on a surface, or a collision in `medium`.
    [[nodiscard]] VertexDepth at_surface(std::int32_t before, const ShapeGeometry& shape,
                                         const SurfacePoint& point) const {
        VertexDepth vertex{before, before + whole_event};
        if (shape.inside_medium == shape.outside_medium) return vertex;
        vertex.front_within = is_within(shape.outside_medium);
        vertex.back_within = is_within(shape.inside_medium);
        vertex.on_body = vertex.front_within || vertex.back_within;
        vertex.came_within = within(vertex, point, point.wo);
        if (vertex.on_body) vertex.least = before + (vertex.came_within ? 1 : whole_event / 2);
        return vertex;
    }
    [[nodiscard]] VertexDepth at_collision(std::int32_t before, std::int32_t medium) const {
        VertexDepth vertex{before, before + whole_event};
        vertex.collision = true;
        vertex.on_body = is_within(medium);
        if (vertex.on_body) vertex.least = before;
        return vertex;
    }
    /// The length of an event at the vertex for a path that goes on in `direction`.
    [[nodiscard]] std::int32_t event(const VertexDepth& vertex, const SurfacePoint& point,
                                     const Vec3& direction) const {
        if (!vertex.on_body) return whole_event;
        if (vertex.collision) return 0;
        const bool goes_within = within(vertex, point, direction);
        if (vertex.came_within != goes_within) return whole_event / 2;
        return goes_within ? 1 : whole_event;
    }

  private:
    static bool within(const VertexDepth& vertex, const SurfacePoint& point, const Vec3& direction) {
        return dot(point.geometric_normal, direction) > 0 ? vertex.front_within : vertex.back_within;
    }

    const MediumTable& media_;
    bool has_bodies_;
    std::int32_t longest_;
    std::uint32_t longest_walk_;
};

}  // namespace raylex::transport
