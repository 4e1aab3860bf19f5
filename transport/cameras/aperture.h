// The stop of a lens system: a disk, one of pbrt-v4's shapes, or an image of the stop.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::transport {

class Aperture {
  public:
    /// An open disk.
    Aperture() = default;
    /// `name` is "circular", "gaussian", "square", "pentagon", "star" or the absolute path of an image. All shapes but
    /// the disk are scaled so that they transmit as much light as the disk.
    static Result<Aperture> named(const std::string& name, const SourceLocation& where);
    [[nodiscard]] static bool is_built_in(const std::string& name);

    /// Transmittance in [0, 1] at (x, y), in units of the stop's radius.
    [[nodiscard]] double transmittance(double x, double y) const;

  private:
    int width_ = 0, height_ = 0;
    std::vector<float> pixels_;  // over [-1, 1]^2 from the top; empty: the disk
};

}  // namespace raylex::transport
