// What a render learned about the directions of its paths, for statistics and documents.
#pragma once

#include <cstdint>

namespace raylex::transport {

struct GuideSummary {
    std::uint32_t samples = 0;  ///< of each pixel for training; none is part of the image. 0: nothing was learned
    std::uint64_t paths = 0;    ///< camera paths of the training
    std::uint64_t regions = 0;  ///< of space and orientation
    std::uint64_t bytes = 0;    ///< of the guide
    double guided = 0;          ///< share of the regions in which the guide draws directions
    double gain = 0;            ///< forecast: variance x cost without the guide over the same with it
    bool used = false;          ///< the render uses the guide
    bool read = false;          ///< from a file: this render has not trained, and `paths` and both times are 0
    bool cut = false;           ///< a time limit or a stop ended the training: closures draw all directions
    double seconds = 0, cpu_seconds = 0;  ///< of the training

    /// PathSettings::guide_samples with which another render has the same guide.
    [[nodiscard]] std::uint32_t repeated() const { return used ? samples : 0; }
};

}  // namespace raylex::transport
