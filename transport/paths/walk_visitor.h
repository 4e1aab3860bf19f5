// What users of a walk (walk.h) are told on its way, and what they are asked.
#pragma once

#include <cstddef>
#include <cstdint>

#include "transport/geometry/ray.h"
#include "transport/geometry/surface_point.h"
#include "transport/materials/bsdf/bsdf.h"
#include "transport/paths/strategies.h"

namespace raylex::transport {

/// What a walk tells and asks, with defaults that do nothing. Derive and hide what matters.
struct WalkVisitor {
    /// Whether subpaths may be split (splits.h).
    static constexpr bool splits = false;
    /// Whether roulette asks for chance() (roulette.h).
    static constexpr bool expects = false;
    /// A ray has hit nothing: its subpath ends.
    void escapes(std::uint32_t /*row*/, const Ray& /*ray*/) {}
    /// Vertex j is an interface with alpha, which no ray stops at, and a light.
    void interface_emits(std::size_t /*j*/) {}
    /// The ray goes straight on through the cutout at vertex j.
    void passes_cutout(std::size_t /*j*/) {}
    /// The subpath has reached vertex j, a surface. False: it ends there.
    bool arrives(std::size_t /*j*/) { return true; }
    /// Whether some of the vertices that subpaths go to are asked for their geometry alone, and whether vertex j, which
    /// arrives() let pass, is asked for more: if not, its closure is black.
    [[nodiscard]] bool may_skip_closures() const { return false; }
    bool needs_closure(std::size_t /*j*/) { return true; }
    /// The densities of a subpath's first vertex are those of `sums`, but for what depends on how it began.
    void first_vertex(std::uint32_t /*row*/, const SurfacePoint& /*point*/, Real /*time*/, StrategySums& /*sums*/) {}
    /// `emitted` is the light that the medium sends back along a ray of a camera subpath.
    void volume_emits(std::uint32_t /*row*/, const Rgb& /*emitted*/) {}
    /// Whether what the medium around the ray scatters could count at all: if not, it only takes light away.
    bool worth_colliding(std::uint32_t /*row*/) { return true; }
    /// The ray flew `distance` through a medium that could only take light away and left `passed`.
    void absorbs(std::uint32_t /*row*/, Real /*distance*/, const Rgb& /*passed*/, const Vec2& /*u*/) {}
    /// The same in a grid, where the flight itself says at which distance light is lost.
    void absorbs_at(std::uint32_t /*row*/, Real /*lost_at*/, const Rgb& /*passed*/) {}
    /// It met a particle after `distance`. False: it ends there.
    bool collides(std::uint32_t /*row*/, Real /*distance*/, const Ray& /*ray*/) { return true; }
    /// Whether what vertex j scatters could count at all: if not, the subpath ends there and no direction is drawn.
    bool worth_scattering(std::size_t /*j*/) { return true; }
    /// The subpath is scattered at vertex j, by these lobes.
    void scatters(std::size_t /*j*/, const LobeList& /*lobes*/) {}
    /// Its throughput is no number: it ends.
    void invalid(std::uint32_t /*row*/) {}
    /// Asked last, before the next ray.
    bool goes_on(std::uint32_t /*row*/) { return true; }
};

}  // namespace raylex::transport
