// `path`: unidirectional path tracing with light sampling at every vertex, combined by the power heuristic.
//
// The path integral is estimated from the camera: at each vertex one light sample (next event estimation) and one
// scattering sample; an emitter can be found by both, and each gets the weight w = p^2 / (p^2 + q^2) of its density p
// against the other's q, per steradian (Veach 1997, chapter 9). Lights without extent are found by sampling alone,
// mirrors by scattering alone. Russian roulette from the second bounce where max(beta) eta^2 is small.
//
// Rays of a batch advance together, one vertex at a time; every stage is one loop over plain arrays:
//
//   trace -> escape to infinite lights -> surfaces -> cutouts pass straight on -> emission -> materials
//         -> light samples into a queue -> trace the queue -> contribute -> scatter, roulette -> next vertex
//
// A batch allocates nothing; per ray there is no virtual call and no lock.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// How emitters are found. `mis` for images; the others estimate the same integral alone, for experiments and tests:
/// `light` leaves area lights to light sampling (emitters seen directly or by delta lobes excepted), `scattering`
/// leaves all but delta lights to scattering.
enum class PathStrategy : std::uint8_t { mis, light, scattering };

/// Which light a light sample goes to: by what each can send to the receiver, where there are many; by emitted power (a
/// tenth of the choices ignores it); or any with one probability.
enum class LightSelection : std::uint8_t { receiver, power, uniform };

struct PathParameters {
    std::uint32_t max_depth = 5;  ///< scattering events at most; emission after the last still counts
    PathStrategy strategy = PathStrategy::mis;
    LightSelection light_selection = LightSelection::receiver;
    Real roulette_below = default_roulette_below;  ///< throughput below which paths end at random; 0: none does
    bool splits = true;                            ///< paths that beauty does not take, where that pays (strategy mis)
    bool channel_roulette = true;                  ///< where beauty is not asked for and it pays (strategy mis)
    bool regularize = false;                       ///< as pbrt-v4: biased, where it blurs
    /// What is found, or said by surfaces, before so many scattering events is left to others (not a parameter).
    std::uint32_t first_depth = 0;
};

/// The integrator itself, for others that are made of it.
std::unique_ptr<Integrator> make_path_integrator(const PathParameters& parameters);

/// The registry's entry: parameters maxdepth, strategy, roulette, rrthreshold, splits, channelroulette,
/// regularize, lightsampler.
Registry<IntegratorFactory>::Entry path_integrator_entry();

}  // namespace raylex::transport
