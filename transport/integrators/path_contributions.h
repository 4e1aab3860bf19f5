// The contributions of single paths of an integrator to the channels, for integrators that examine whole paths before
// they splat them, such as Metropolis light transport.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// The contributions of one path, at the raster position of its camera ray and at those of its splats.
struct PathContribution {
    std::vector<Vec2> positions;  ///< on the raster, in pixels; the camera ray's comes first
    std::vector<double> values;   ///< [position][channel][colour]
    std::uint32_t refused = 0;    ///< number of values that were not finite; `values` holds none of them
};

/// The number of a path, counted over all tiles. Each tile has `paths_of_tile` of them.
[[nodiscard]] constexpr std::uint64_t path_number(std::uint64_t tile, std::uint64_t paths_of_tile, std::uint64_t path) {
    return tile * paths_of_tile + path;
}
/// The number of a sample, distinct for all mutations of all paths; both numbers are below 2^32.
[[nodiscard]] constexpr std::uint64_t sample_number(std::uint64_t path, std::uint64_t mutation) {
    return (path << 32) + mutation;
}

/// The paths of one thread. They have a sample table of their own, so they add nothing to the image.
class PathContributions final : display::RasterSink {
  public:
    /// Follows paths of `integrator` and computes their contributions to `channels`, which are channels of light. All
    /// arguments must outlive this object.
    PathContributions(const IntegratorContext& context, const Integrator& integrator,
                      const std::vector<display::ChannelId>& channels);
    PathContributions(const PathContributions&) = delete;  // its parts point to one another
    PathContributions& operator=(const PathContributions&) = delete;

    /// Begins a path by its random numbers: a camera ray through a raster position drawn uniformly over the area that
    /// adds to the image (CameraView::reached()). The paths of one call of follow() need distinct `sample`s.
    void begin(std::size_t row, const PixelSampler& numbers, std::uint64_t sample);
    /// Follows the paths of the first `count` rows. Returns false if the render ends before the paths do: their
    /// contributions are then incomplete.
    [[nodiscard]] bool follow(std::size_t count, ThreadServices& services);
    /// Counts and logs the refused values of a path (Law 6), as splats that the engine examines.
    void report_refused(std::size_t row, ThreadServices& services) const;

    [[nodiscard]] std::size_t size() const { return rows_.size(); }  ///< most paths of one call
    [[nodiscard]] const display::CameraRow& row(std::size_t row) const { return rows_[row]; }
    [[nodiscard]] PathContribution& operator[](std::size_t row) { return contributions_[row]; }
    [[nodiscard]] IntegratorCounters& counters() { return thread_->counters; }

  private:
    void take(display::SampleTable& splats) override;

    const IntegratorContext& context_;
    const Integrator& integrator_;
    const std::vector<display::ChannelId>& channels_;
    display::SampleTable table_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
    display::RasterSplats raster_;
    std::unique_ptr<IntegratorThread> thread_;
    std::vector<display::CameraRow> rows_;
    std::vector<Ray> rays_;
    std::vector<PixelSampler> samplers_;
    std::vector<PathContribution> contributions_;            // [row]
    std::unordered_map<std::uint64_t, std::size_t> row_of_;  // by CameraRow::sample
};

}  // namespace raylex::transport
