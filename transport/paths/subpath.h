// What a subpath carries from vertex to vertex, and which numbers of its sample each vertex takes.
//
// Subpath is what every stage reads: one cache line. What few renders need stands in arrays of the walk, by row, which
// exist only where something reads them: SplitState where a plan changes paths, TechniqueShares where a plan has
// shares or a sampler of directions plans rays, PartialMisWeights where the method reads densities, travelled distances
// where there are cutouts.
#pragma once

#include <cstdint>

#include "transport/materials/bsdf/scatter.h"
#include "transport/math/real.h"
#include "transport/math/vec.h"
#include "transport/paths/path_depth.h"

namespace raylex::transport {

/// The throughput below which paths end at random by default. pbrt-v4's 1 ends a path in a white room nearly as soon as
/// it may. A quarter costs 1.3 times the time and leaves less than half the squared error (experiments/docs/
/// measured/methods.md). From 0.1 to 0.5 the product of time and squared error changes little.
inline constexpr Real default_roulette_below = Real(0.25);

/// Sampler dimensions that the engine uses itself: pixel filter, lens, shutter time, wavelength.
inline constexpr std::uint32_t filter_dimension = 0, lens_dimension = 1, time_dimension = 2, wavelength_dimension = 3,
                               first_free_dimension = 8;

struct alignas(64) Subpath {
    Rgb beta{1};  ///< throughput: product of scattering weights; of a light subpath the power it carries
    /// The factor by which roulette scales the throughput before it compares it with the threshold. Of a camera
    /// subpath: the product of eta^2 over its transmissions, which cancels their scaling of radiance; it is multiplied.
    /// Of a light subpath: its initial power, by which beta is divided.
    Real roulette_scale = 1;
    /// Density of the last direction, as multiple importance sampling uses it: the sampler's density per steradian,
    /// times the number of rays that leave a split vertex, times the share of scattering rays at a last vertex
    /// (TechniqueShares::ray). Of a specular direction: the probability of its lobe, without these factors. Of the
    /// first ray of a light subpath: EmissionDensity::direction, or 0 if the walk keeps no densities. 0 for a camera
    /// ray.
    Real pdf = 0;
    Vec3 from;                  ///< the vertex that the last ray left; initially a point on the camera or the light
    Vec3 from_normal;           ///< shading normal at `from`; zero where there is no surface
    std::uint32_t depth = 0;    ///< number of scattering events so far
    std::int32_t length = 0;    ///< sum of the lengths of these events, which "maxdepth" bounds (path_depth.h)
    std::uint32_t segment = 0;  ///< number of rays so far, also of those behind cutouts: keys choices made once a ray
    std::int32_t medium = -1;   ///< medium that the next ray crosses; -1: none
    /// Number of the chooser (LiveLights) from which the vertex that the ray leaves draws its light sample.
    std::uint8_t lights = 0;
    bool specular = true;  ///< the last direction is the camera's or a delta lobe's: light sampling cannot find it
    bool any_non_specular = false;  ///< some scattering was not specular
    bool one_wavelength = false;    ///< has met an interface whose index depends on the wavelength (path_wavelengths.h)
};
static_assert(sizeof(Real) > 4 || sizeof(Subpath) <= 64, "what every stage reads fits into a cache line");

/// How many rays leave the vertices of a camera subpath, and by which lobes (splits.h).
struct SplitState {
    std::uint8_t rays = 1;      ///< number of rays that leave the current vertex
    bool all_lobes = false;     ///< one ray leaves the current vertex by each of its specular lobes
    bool split = false;         ///< rays were split at this vertex or before
    std::uint8_t followed = 0;  ///< number of specular vertices behind the split at which all lobes were followed
    Real expected = 1;          ///< mean of `rays`, by which the throughput is divided

    [[nodiscard]] std::uint32_t branches() const { return all_lobes ? 2 : rays; }
};

/// Sampler dimensions of a subpath: those of a vertex begin at `first` + scattering events so far * `stride`.
struct SubpathDimensions {
    std::uint32_t first, stride;
    std::uint32_t scatter, lobe, roulette, key;  ///< of a vertex
    std::uint32_t cutouts, flights;              ///< of a ray, far above the dimensions of every vertex
    std::uint32_t null_collisions;               ///< keys of further numbers of a ray, in grids
    std::uint32_t connections;                   ///< keys of numbers of shadow rays, in grids, by the vertex's depth

    [[nodiscard]] constexpr std::uint32_t of(std::uint32_t depth, std::uint32_t which) const {
        return first + depth * stride + which;
    }
};
/// The first of the dimensions, one for each scattering event, that decide whether a vertex of a camera subpath takes a
/// light sample.
inline constexpr std::uint32_t light_technique_dimensions = 1u << 23;
/// Further dimensions of a vertex, for the light sample of a camera subpath and for the lens position to which a light
/// subpath is connected.
inline constexpr std::uint32_t light_choice_dimension = 0, light_sample_dimension = 1, camera_lens_dimension = 0;

/// Dimensions of the start of a light subpath: light_dimensions + one of these.
enum EmissionDimension : std::uint32_t { emitter_dimension, origin_dimension, direction_dimension };
inline constexpr std::uint32_t light_dimensions = 1u << 26;

template <TransportMode mode>
inline constexpr SubpathDimensions subpath_dimensions =
    mode == TransportMode::radiance ? SubpathDimensions{.first = first_free_dimension,
                                                        .stride = 6,
                                                        .scatter = 2,
                                                        .lobe = 3,
                                                        .roulette = 4,
                                                        .key = 5,
                                                        .cutouts = 1u << 24,
                                                        .flights = 1u << 25,
                                                        .null_collisions = 1u << 28,
                                                        .connections = 5u << 26}
                                    : SubpathDimensions{.first = light_dimensions + 8,
                                                        .stride = 5,
                                                        .scatter = 1,
                                                        .lobe = 2,
                                                        .roulette = 3,
                                                        .key = 4,
                                                        .cutouts = 1u << 27,
                                                        .flights = 3u << 26,
                                                        .null_collisions = 3u << 27,
                                                        .connections = 7u << 26};

}  // namespace raylex::transport
