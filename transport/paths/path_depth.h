// How long a path is for "maxdepth".
//
// An event is a scattering. Inside bodies of subsurface materials paths scatter hundreds of times where pbrt looks up
// one event in a table. So scatterings in a body's medium do not count, a passage through its surface counts 1/2, and a
// reflection from within 1/64. 31 such reflections are free, which covers all but 10^-7 of the light (a body of eta 1.5
// keeps 0.6 of the light that comes to its surface), and total reflection, which may never end, has a bound. Everything
// else is a whole event, also at things that stand in a body.
//
// What a scattering counts follows from its own surface, or the medium around it, and its two directions, never from
// the way that rays took before: all strategies count alike, those that connect subpaths too, in bodies with holes or
// the wrong way out. The medium of one that is open, or the wrong way out, may fill all of space, and where it absorbs
// nothing a walk there has no end: a subpath has at most 65,536 scatterings, or "maxdepth" where that is more. A half
// space that absorbs nothing has let 99.6 % of its light out by then: 2 / sqrt(pi n) is left after n steps of any
// symmetric kind, the first of them inwards (Sparre Andersen 1954), surface and index apart.
#pragma once

#include <cstdint>

#include "transport/embree/embree_scene.h"
#include "transport/geometry/surface_point.h"
#include "transport/media/medium.h"

namespace raylex::transport {

/// Lengths are in 1/64 of an event.
inline constexpr std::int32_t whole_event = 64;

/// A vertex from which a path may go on or be connected: the length of the path that leads there, and which sides are
/// within bodies.
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
    /// Whether a subpath of so many scatterings may have one more, where there are bodies.
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
