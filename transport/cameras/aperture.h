// What the stop of a lens system lets through: a disk, one of pbrt-v4's shapes, or an image of the stop.
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
    /// "circular", "gaussian", "square", "pentagon" or "star", or the absolute path of an image. All but the disk are
    /// scaled so that they let through as much as it does.
    static Result<Aperture> named(const std::string& name, const SourceLocation& where);
    [[nodiscard]] static bool is_built_in(const std::string& name);

    /// At (x, y), the stop's radius being 1.
    [[nodiscard]] double transmittance(double x, double y) const;

  private:
    int width_ = 0, height_ = 0;
    std::vector<float> pixels_;  // over [-1, 1]^2 from the top; empty: the disk
};

}  // namespace raylex::transport
