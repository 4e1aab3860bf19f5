// `pssmlt`: Metropolis light transport in primary sample space (C. Kelemen et al. 2002, "A Simple and Robust Mutation
// Strategy for the Metropolis Light Transport Algorithm") over path tracing or bidirectional path tracing.
//
// A state u is the numbers that a path draws: raster position, light samples, scattering and roulette. F(u) is what the
// path adds to each channel, and the scalar contribution I(u) is the mean over the colours of what it adds to the
// target: beauty, or the channels that the user names. Markov chains walk over states with a density proportional to I.
// pssmlt.cpp cites these formulas by their numbers:
//
//   (1)  I(u) = (|F_r(u)| + |F_g(u)| + |F_b(u)|) / 3       scalar contribution
//   (2)  b = mean of I over independent states             normalisation
//   (3)  a(u -> v) = min(1, I(v) / I(u))                   acceptance; small and large steps are symmetric
//   (4)  w(v) = (a + [large step]) / (I(v) / b + p)        weight of the proposal, and
//   (5)  w(u) = (1 - a) / (I(u) / b + p)                   of the state before it: Kelemen's equations 11 and 12
//   (6)  image = mean over all steps of w F                expected values: both states of each step are splatted
//
// p is the probability of a large step, which draws a new independent state. (4) and (5) combine the chain and the
// large steps by the balance heuristic, so large steps alone find light that the target takes nothing of: without bias,
// and with the noise of independent paths. An error of b is an error of the whole image, which pixels do not show;
// renders with other seeds do.
//
// Over bdpt, a state includes what its light subpath adds at other raster positions (t = 1). Camera rays bring what
// they see directly (C L, C B, C O) and AOVs, alpha and mattes; chains bring the paths that scatter. One step of a
// chain is a light path of ThreadServices::raster, so n samples a pixel are n x width x height steps.
//
// The chains walk over the whole image, but each belongs to a tile by number. The threads meet after every 16 samples a
// pixel (synchronous()), and one thread at a time advances the chains of a tile, so images have the same bits for any
// number of threads (Law 3). Checkpoints, replays of one sample, holdouts and prefixes are refused: the state of a
// chain is no function of a sample number.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// The registry's entry: parameters maxdepth, largestepprobability, sigma, chains, bootstrapsamples (as pbrt's mlt),
/// roulette, rrthreshold, integrator, target.
Registry<IntegratorFactory>::Entry pssmlt_entry();

}  // namespace raylex::transport
