// A scene that fails, made small: what is not needed to fail is taken out of its text.
//
// Delta debugging (Zeller and Hildebrandt 2002, "Simplifying and Isolating Failure-Inducing Input"): halves, quarters
// ... of the directives, then blocks, parameters and faces of meshes one by one, then numbers towards 0 and 1 and fewer
// digits, again and again until nothing more can go. What is no scene any more does not fail, so no grammar is needed.
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

/// `text`: one directive a line, as pbrt_text() writes it. `fails`: whether a text still fails in the same way; it is
/// called for texts that are no scenes, too.
Shrunk shrink_scene(const std::string& text, const std::function<bool(const std::string&)>& fails,
                    const ShrinkLimits& limits = {});

}  // namespace raylex::experiments
