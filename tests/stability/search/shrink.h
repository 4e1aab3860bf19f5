// Shrinks a failing scene: removes everything from its text that is not needed for the failure.
//
// Delta debugging (Zeller and Hildebrandt 2002, "Simplifying and Isolating Failure-Inducing Input"): tries to remove
// halves, quarters ... of the directives, then single blocks, parameters and mesh faces; then it moves numbers towards
// 0 and 1 and removes digits. It repeats until nothing can be removed. A text that is not a scene does not fail in the
// same way, so no grammar is needed.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace raylex::experiments {

struct ShrinkLimits {
    std::size_t most_trials = 3000;
    double seconds = 120;
};
struct Shrunk {
    std::string text;
    std::size_t trials = 0;
};

/// Shrinks `text`, which has one directive per line, as pbrt_text() writes it. `fails` returns whether a text still
/// fails in the same way; it is also called for texts that are not scenes.
Shrunk shrink_scene(const std::string& text, const std::function<bool(const std::string&)>& fails,
                    const ShrinkLimits& limits = {});

}  // namespace raylex::experiments
