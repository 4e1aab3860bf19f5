// What stands between closure and walk: where a path goes on from a vertex.
//
// By default the closure of the vertex (in media: the phase function) draws the direction. A render may put another
// sampler in between (PathContext::directions), for example one that learned where light comes from. Everything that
// depends on densities of directions then uses the sampler's: scattering, the weights of light samples and of
// connections, and reverse densities. So all techniques agree on one set of densities, and their weights sum to 1.
//
// A sampler is used at vertices whose closure has a density. At mirrors and smooth glass the closure alone decides.
#pragma once

#include "transport/geometry/surface_point.h"
#include "transport/materials/closures/closure.h"

namespace raylex::transport {

/// Shared by all threads of a render. Its densities must not change while a batch is underway.
class DirectionSampler {
  public:
    virtual ~DirectionSampler() = default;

    /// Draws the direction in which a path of `mode` goes on that came from point.wo. u_lobe and u in [0, 1). Of a
    /// direction with a density only `wi` and `pdf` are read: the walk evaluates the closure there. Its pdf must be the
    /// pdf() of the direction as rounded. Of a specular direction (`delta`) everything is read: it must be a sample of
    /// the closure whose pdf was multiplied, and whose weight was divided, by the probability of drawing from the
    /// closure. pdf 0: the path ends.
    [[nodiscard]] virtual BsdfSample sample(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode,
                                            Real u_lobe, const Vec2& u) const = 0;
    /// The density per steradian with which sample() draws `to` for a path of `mode` that came from `from`. Specular
    /// directions are left out.
    [[nodiscard]] virtual Real pdf(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, const Vec3& from,
                                   const Vec3& to) const = 0;
};

/// The density per steradian with which a path of `mode` that came from `from` goes on to `to`. `directions`: null
/// where closures draw directions themselves.
template <TransportMode mode>
[[gnu::always_inline]] inline Real direction_density(const DirectionSampler* directions, const Bsdf& bsdf,
                                                     const SurfacePoint& point, const Vec3& from, const Vec3& to) {
    return directions == nullptr ? bsdf.pdf(from, to) : directions->pdf(bsdf, point, mode, from, to);
}

}  // namespace raylex::transport
