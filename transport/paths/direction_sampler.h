// Samplers of the direction in which a path continues from a vertex.
//
// By default the closure of the vertex (in media: the phase function) samples the direction. A render may use another
// sampler (PathContext::directions), for example one that learned where light comes from. All densities of directions
// are then those of the sampler: for scattering, for the weights of light samples and of connections, and in reverse.
// So all techniques use one set of densities, and their weights sum to 1.
//
// A sampler is used at vertices whose closure has a density. At mirrors and smooth glass the closure alone decides.
#pragma once

#include <span>

#include "transport/geometry/surface_point.h"
#include "transport/materials/closures/closure.h"

namespace raylex::transport {

/// All threads of a render share the object. Its densities must not change during a batch.
class DirectionSampler {
  public:
    virtual ~DirectionSampler() = default;

    /// Sets SurfacePoint::direction_region of new vertices to what their densities depend on. The other functions
    /// accept points without it.
    virtual void locate(std::span<SurfacePoint> points) const { static_cast<void>(points); }

    /// Whether rays() determines how many rays leave the vertices of camera subpaths, and light_share() how many light
    /// samples they take. Only `path` supports it. Otherwise a plan and throughput
    /// do.
    [[nodiscard]] virtual bool plans_rays() const { return false; }
    /// The mean number of rays that leave a vertex, above 0, where a path arrives with a throughput of this mean
    /// colour. It must not depend on samples that follow.
    [[nodiscard]] virtual Real rays(const Bsdf& bsdf, const SurfacePoint& point, Real throughput) const {
        static_cast<void>(bsdf), static_cast<void>(point), static_cast<void>(throughput);
        return 1;
    }
    /// The probability, above 0, with which a vertex takes a light sample, where rays() determines the number of rays.
    /// It must not depend on samples that follow. Not called for closures whose mean depends on the weights of light
    /// samples (Bsdf::depends_on_weights()).
    [[nodiscard]] virtual Real light_share(const SurfacePoint& point, Real throughput) const {
        static_cast<void>(point), static_cast<void>(throughput);
        return 1;
    }

    /// Samples the direction in which a path of `mode` that arrived from point.wo continues; u_lobe and u are in [0,
    /// 1). For a direction with a density, `pdf` must equal pdf() of the rounded `wi`, which is the density of the
    /// draw, except where BsdfSample::drawn_over_pdf is not 1. The walk evaluates the closure for `wi`, unless the
    /// result is_weighed; then `weight` and `lobes` are those of the sample. A specular direction
    /// (`delta`) must be a sample of the closure: its pdf is multiplied, and its weight divided, by the probability of
    /// sampling the closure. If pdf is 0, the path ends.
    [[nodiscard]] virtual BsdfSample sample(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode,
                                            Real u_lobe, const Vec2& u) const = 0;
    /// The density per steradian with which sample() returns `to` for a path of `mode`. `closure_pdf`: the density with
    /// which the closure draws `to` for the direction that the path arrived from. Specular directions are not included.
    [[nodiscard]] virtual Real pdf(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, const Vec3& to,
                                   Real closure_pdf) const = 0;
};

/// The density per steradian with which a path of `mode` that arrived from `from` continues to `to`. If `directions` is
/// null, the closure samples directions.
template <TransportMode mode>
[[gnu::always_inline]] inline Real direction_density(const DirectionSampler* directions, const Bsdf& bsdf,
                                                     const SurfacePoint& point, const Vec3& from, const Vec3& to) {
    const Real by_closure = bsdf.pdf(from, to);
    return directions == nullptr ? by_closure : directions->pdf(bsdf, point, mode, to, by_closure);
}

}  // namespace raylex::transport
