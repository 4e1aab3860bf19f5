// Cases that render.
#pragma once

#include "experiments/stability/probe.h"
#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {

/// One image for people to look at: linear RGB, rows from the top.
struct CaseImage {
    int width = 0, height = 0;
    std::vector<float> rgb;
};

/// Renders the scene by the integrator that stands at `integrator` in the subject, once for each seed, and measures
/// what the case asks for. `threads` render, unless the case says how many. Errors are those of formulas, of the scene
/// and of the render, but where the outcome is what is asked for. `image`, unless null, gets the beauty of the first
/// seed.
Result<ProbeResult> measure_scene(const SceneSubject& subject, std::size_t integrator, const Setting& setting,
                                  int threads, CaseImage* image);

}  // namespace raylex::experiments
