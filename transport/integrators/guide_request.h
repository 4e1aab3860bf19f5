// What a method requests of a guide of its directions (paths/guide/guide.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace raylex::transport {

class Integrator;

/// Whether directions of paths are learned before the render (paths/guide/guide.h).
enum class GuideMode : std::uint8_t { off, automatic, on };

struct GuideRequest {
    GuideMode mode = GuideMode::off;
    std::uint32_t samples = 0;  ///< of each pixel for training; 0: by the samples or the time of the render
    /// Expected gain decides how many rays leave a vertex (paths/guide/guide_gains.h); otherwise throughput does.
    bool gain = false;
    /// Makes an integrator that traces the paths of the training. The context of its prepare() has the guide.
    std::function<std::unique_ptr<Integrator>()> make_trial;
};

}  // namespace raylex::transport
