// `pssmlt`: Metropolis light transport in primary sample space (C. Kelemen et al. 2002) over path tracing or
// bidirectional path tracing.
//
// A path, light samples, scattering and MIS weights and all, is a function of the numbers that it asks for; so is a
// pair of subpaths with all their joins. Markov chains walk over these numbers (samplers/primary_samples.h), raster
// position included, with a stationary density proportional to the luminance-like mean f of what the path brings to
// beauty. Both states of every step are used, weighted by their expectation and by the balance heuristic between chain
// and independent large steps (Kelemen's eq. 11 and 12): the proposal splats (a + [large]) / (f / b + p), the state
// that it may replace (1 - a) / (f / b + p), times their values in every channel. Splats are exact for each channel:
// what a word brings is splatted to its channels, never b or f. What a state brings to other raster positions than its
// own (t = 1 of bdpt) belongs to it: f is the sum of all.
//
// f is the mean over the colours of what a path brings to the target: beauty, or the channels that the user names.
// Light of which the target takes nothing comes from large steps alone, without bias and with the noise of independent
// paths.
//
// b, the mean of f, comes from a bootstrap of independent paths, and of every large step since. The bootstrap runs as a
// start-up: its calls end in DiscardIteration and nothing of it reaches a channel. Chains begin in bootstrap paths
// drawn in proportion to f. Where b is off by a share e, so is, in expectation, a part of the image: errors of b are
// counted by comparing seeds, not pixels.
//
// Chains belong to tiles of the image by number only, they roam over all of it; the threads meet after every 16 samples
// a pixel (synchronous()), and a tile's chains are advanced by one thread in between. So images have the same bits for
// any number of threads (Law 3). Camera rays bring what they see directly (C L, C B, C O) and AOVs, alpha and mattes;
// chains bring paths that scatter. One step of a chain is a light path of ThreadServices::raster: n samples a pixel are
// n x width x height steps. Checkpoints, replays of one sample, holdouts and prefixes are refused: chains are no
// functions of sample numbers.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

struct PssmltParameters {
    std::uint32_t max_depth = 5;
    Real large_step_probability = Real(0.3);
    Real sigma = Real(0.01);      ///< standard deviation of a small step
    std::uint32_t chains = 1000;  ///< in all; at least one a tile
    std::uint32_t bootstrap_samples = 100'000;
    Real roulette_below = default_roulette_below;  ///< 0: paths do not end at random
    bool bidirectional = false;                    ///< over bdpt
    std::vector<std::string> target;               ///< channels; empty: beauty, or all channels where there is none
    SourceLocation location;                       ///< of the directive, for errors
};

/// The registry's entry: parameters maxdepth, largestepprobability, sigma, chains, bootstrapsamples (as pbrt's mlt),
/// roulette, rrthreshold, integrator, target.
Registry<IntegratorFactory>::Entry pssmlt_entry();

}  // namespace raylex::transport
