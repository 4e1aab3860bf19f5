// Cases that render scenes.
#pragma once

#include "experiments/stability/probe.h"
#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {

/// An image for people: linear RGB, rows from the top.
struct CaseImage {
    int width = 0, height = 0;
    std::vector<float> rgb;
};

/// Renders the scene once per seed, with the integrator at index `integrator` of the subject, and measures as the case
/// requires. Uses `threads` threads unless the case sets a number. Errors: those of formulas, of the scene and of the
/// render, except if the outcome is measured. `image`, unless null, receives the beauty of the first seed.
Result<ProbeResult> measure_scene(const SceneSubject& subject, std::size_t integrator, const Setting& setting,
                                  int threads, CaseImage* image);

}  // namespace raylex::experiments
