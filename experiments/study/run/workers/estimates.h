// What cells will take: from a short render of every scene by every variant, and from the cells that have been run.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "experiments/study/run/workers/cell_worker.h"

namespace raylex::experiments {

/// One such render.
Result<Calibration> calibration_of(const ExperimentConfig& config, SceneStore& scenes, std::size_t scene,
                                   std::size_t variant, const std::atomic<bool>* stop);

class Estimates {
  public:
    explicit Estimates(const ExperimentConfig& config) : config_(config) {}

    /// Renders each scene by each variant of this program for a fifth of a second or 64 samples, which also warms up
    /// caches and clocks. Scenes in `skips` are left out. Returns what the renders warned of and why a time is not
    /// known, each once; nothing more is done after an interrupt.
    std::vector<std::string> calibrate(CellWorker& worker, const Plan& plan, const std::set<std::size_t>& skips,
                                       const std::atomic<bool>* stop);
    /// Takes note of a cell that is done.
    void learn(const PlannedCell& planned, const Cell& done, double relative_error);

    /// Wall seconds of the cell's render; nothing where nothing like it has been run.
    [[nodiscard]] std::optional<double> seconds(const PlannedCell& planned) const;
    /// Of one sample of the whole image; 0 where not known.
    [[nodiscard]] double seconds_per_sample(const PlannedCell& planned) const;
    /// Resident at most while it was calibrated; 0 where it was not.
    [[nodiscard]] std::uint64_t peak_memory_bytes() const { return peak_memory_bytes_; }
    /// Of the scene's reference.
    [[nodiscard]] std::optional<double> reference_seconds(std::size_t scene) const;

  private:
    struct Rate {
        double setup = 0, seconds = 0, samples = 0;  ///< of one render; sums without it
        double error_root = -1;  ///< relative error times the root of the samples; negative: not known
    };
    [[nodiscard]] std::optional<double> seconds_of(std::size_t scene, std::size_t variant, double samples,
                                                   double error) const;
    const ExperimentConfig& config_;
    std::map<std::pair<std::size_t, std::size_t>, Rate> rates_;
    std::uint64_t peak_memory_bytes_ = 0;
};

}  // namespace raylex::experiments
