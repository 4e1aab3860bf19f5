// Estimates the costs of cells, from a short render of every scene with every variant and from finished cells.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "experiments/study/run/workers/run_worker.h"

namespace raylex::experiments {

/// Makes one such render.
Result<Calibration> calibration_of(const ExperimentConfig& config, SceneStore& scenes, std::size_t scene,
                                   std::size_t variant, const std::atomic<bool>* stop);

class Estimates {
  public:
    explicit Estimates(const ExperimentConfig& config) : config_(config) {}

    /// Renders each scene with each variant of raylex for a fifth of a second or 64 samples, which also warms up caches
    /// and clocks. Scenes in `skips` are left out. Returns each warning of the renders, and each reason for an unknown
    /// time, once. Stops after an interrupt.
    std::vector<std::string> calibrate(RunWorker& worker, const Plan& plan, const std::set<std::size_t>& skips,
                                       const std::atomic<bool>* stop);
    /// Learns from a finished cell.
    void learn(const PlannedRun& planned, const StudyRun& done, double relative_error);

    /// Returns the wall seconds of the cell's render; nothing if no similar cell has run.
    [[nodiscard]] std::optional<double> seconds(const PlannedRun& planned) const;
    /// Returns the seconds per sample of the whole image; 0 if unknown.
    [[nodiscard]] double seconds_per_sample(const PlannedRun& planned) const;
    /// Returns the peak memory of the calibration in bytes; 0 without calibration.
    [[nodiscard]] std::uint64_t peak_memory_bytes() const { return peak_memory_bytes_; }
    /// Returns the seconds for the scene's reference.
    [[nodiscard]] std::optional<double> reference_seconds(std::size_t scene) const;

  private:
    struct Rate {
        double setup = 0, seconds = 0, samples = 0;  ///< of one render; sums without setup
        double error_root = -1;  ///< relative error times the root of the number of samples; negative: unknown
    };
    [[nodiscard]] std::optional<double> seconds_of(std::size_t scene, std::size_t variant, double samples,
                                                   double error) const;
    const ExperimentConfig& config_;
    std::map<std::pair<std::size_t, std::size_t>, Rate> rates_;
    std::uint64_t peak_memory_bytes_ = 0;
};

}  // namespace raylex::experiments
