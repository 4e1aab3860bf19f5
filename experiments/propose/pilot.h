// Small renders that measure the noise and the cost of methods, by classes of paths. Their samples enter no image.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {

struct PilotSettings {
    int longer_side = 64;        ///< of the image in pixels
    std::uint64_t samples = 16;  ///< per pixel and seed
    unsigned seeds = 8;          ///< independent renders, at least 3
    std::uint64_t seed = 0;      ///< of the first one
};

/// The noise of one sample per pixel, measured between seeds. Squared errors are relative to the squared mean pixel.
struct PilotNoise {
    double squared = 0, standard_error = 0;  ///< mean squared error without the largest 0.1 %, and its standard error
    double worst_share = 0;                  ///< fraction of the sum of squared errors in the largest 0.1 %
    double light = 0, light_error = 0;       ///< mean pixel, and its standard error
};

/// One method that renders some classes of paths.
struct PilotPass {
    std::vector<PilotNoise> of_class;         ///< in the order of the classes that were rendered
    PilotNoise whole;                         ///< all these classes together
    std::vector<std::vector<double>> images;  ///< [seed] of all these classes
    double samples = 0;                       ///< per pixel of each image
    double cpu_seconds = 0;                   ///< of one sample of one pixel, median of the seeds
};

/// Renders pilots of one scene.
class Pilot {
  public:
    /// `job` has the settings of the scene's render; `resolution` is that of its image.
    Pilot(const Job& job, const transport::BuiltScene& scene, std::array<int, 2> resolution,
          const PilotSettings& settings);

    /// Renders classes, by their light path expressions, by a method: pruned to them unless they are all paths. Uses
    /// PilotSettings::samples if `samples` is 0. The first call sets the mean pixel that errors are relative to.
    /// Errors: the method does not support the scene or the job.
    Result<PilotPass> measure(const transport::SceneEntity& method, const std::vector<std::string>& classes, bool all,
                              double samples = 0);

    [[nodiscard]] std::array<int, 2> resolution() const { return resolution_; }

    /// Returns the noise of the sum of passes with these numbers of samples.
    [[nodiscard]] PilotNoise noise_of(const std::vector<const PilotPass*>& passes,
                                      const std::vector<double>& samples) const;

  private:
    /// `scale` is what squared errors are multiplied by.
    [[nodiscard]] PilotNoise noise_of(const std::vector<std::vector<double>>& images, double scale) const;

    const Job& job_;
    const transport::BuiltScene& scene_;
    std::array<int, 2> resolution_;
    PilotSettings settings_;
    double brightness_ = 0;  // mean pixel
};

}  // namespace raylex::experiments
