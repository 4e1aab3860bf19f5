// `path`: unidirectional path tracing with light sampling at every vertex, combined by the power heuristic.
//
// The path integral is estimated from the camera. Each vertex takes one light sample (next event estimation) and one
// scattering sample. Both can find an emitter: each gets the weight w = p^2 / (p^2 + q^2) of its density p against the
// other's density q, per steradian (Veach 1997, equation 9.13 with beta = 2). Lights without extent are found by
// sampling alone, mirrors by scattering alone. From the second scattering on, a path ends at random where
// max(beta) eta^2 is below `roulette_below`.
#pragma once

#include "transport/integrators/integrator.h"
#include "transport/paths/subpaths/direct_light.h"

namespace raylex::transport {

/// How the light of a light sample is chosen: by what each can send to the receiver, where there are many; by emitted
/// power (one choice in ten is uniform); or with the same probability for each.
enum class LightSelection : std::uint8_t { receiver, power, uniform };

struct PathParameters {
    std::uint32_t max_depth = 5;  ///< scattering events at most; emission after the last still counts
    PathStrategy strategy = PathStrategy::mis;
    LightSelection light_selection = LightSelection::receiver;
    Real roulette_below = default_roulette_below;  ///< throughput below which paths end at random; 0: none does
    bool splits = true;             ///< without beauty: split paths where a plan says that it pays (strategy mis)
    bool channel_roulette = true;   ///< without beauty: roulette by what channels still expect (strategy mis)
    bool regularize = false;        ///< as pbrt-v4: roughens lobes behind a non-specular scattering; biased
    std::uint32_t first_depth = 0;  ///< WalkOptions::first_depth (not a parameter)
};

/// The integrator itself, for integrators that are made of it.
std::unique_ptr<Integrator> make_path_integrator(const PathParameters& parameters);

/// The registry's entry: parameters maxdepth, strategy, roulette, rrthreshold, splits, channelroulette, regularize,
/// lightsampler.
Registry<IntegratorFactory>::Entry path_integrator_entry();

}  // namespace raylex::transport
