// `path`: unidirectional path tracing with light sampling at every vertex, combined by the power heuristic.
//
// The path integral (Veach 1997, equation 8.5) is estimated from the camera. Each vertex takes one light sample (next
// event estimation) and one scattering sample. Both can find an emitter: each gets the weight w = p^2 / (p^2 + q^2) of
// its density p against the other's density q, per steradian (equation 9.13 with beta = 2). Lights without extent are
// found by sampling alone, mirrors by scattering alone. From the second scattering on, a path ends at random where
// max(beta) eta^2 is below `roulette_below`.
#pragma once

#include "transport/integrators/integrator.h"
#include "transport/paths/subpaths/direct_light.h"

namespace raylex::transport {

/// Of WalkOptions, parameters of the integrator are max_depth, roulette_below and regularize.
struct PathParameters : WalkOptions {
    PathStrategy strategy = PathStrategy::mis;
    LightSelection light_selection = LightSelection::receiver;
    bool splits = true;            ///< without beauty: split paths where the plan finds a gain (strategy mis)
    bool channel_roulette = true;  ///< without beauty: roulette by what channels may still receive (strategy mis)
    GuideRequest guide{};          ///< without make_trial
};

/// Makes the integrator for other integrators that use it.
std::unique_ptr<Integrator> make_path_integrator(const PathParameters& parameters);

/// The registry's entry: parameters maxdepth, strategy, roulette, rrthreshold, splits, channelroulette, regularize,
/// lightsampler, guide, guidesamples, guideroulette.
Registry<IntegratorFactory>::Entry path_integrator_entry();

}  // namespace raylex::transport
