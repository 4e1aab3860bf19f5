// All that can die of a scene, done where it takes nobody along: loading, calibrating, references, cells. The process
// that does it is begun anew when it has died, and then loads what it needs again.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiments/job/text/json.h"
#include "experiments/study/run/cells/cell_runner.h"
#include "experiments/study/run/processes/child_process.h"
#include "experiments/study/run/workers/worker_service.h"

namespace raylex::experiments {

/// A scene as far as its loading tells.
struct DescribedScene {
    SceneInfo info;  ///< hash, size, channels
    std::vector<PartitionInfo> partitions;
};

/// A short render that is thrown away.
struct Calibration {
    double setup_seconds = 0;  ///< the integrator's preparation, the same for any number of samples
    double seconds = 0, samples = 0, relative_error = -1;  ///< of rendering; samples per pixel
    std::vector<std::string> warnings;
    std::uint64_t peak_memory_bytes = 0;
};

class CellWorker {
  public:
    /// The config and the plan outlive it, and do not change once it has been asked for anything. `isolated`: false
    /// does everything in this process. `in_process` is called first in every process that is begun.
    CellWorker(const ExperimentConfig& config, const Plan& plan, std::string directory, const std::atomic<bool>* stop,
               bool isolated, std::function<void()> in_process = {});

    Result<DescribedScene> describe(std::size_t scene, std::size_t variant);
    Result<std::uint64_t> frame_buffer_bytes(std::size_t scene, std::size_t variant);
    /// reason_of_scene() of cell_parts.h; empty where the scene cannot be loaded: its cells will say so.
    std::string reason_to_keep(std::size_t scene, std::size_t variant);
    Result<Calibration> calibrate(std::size_t scene, std::size_t variant);
    /// provide_reference(); what dies, or fails to render, is told in info.reference_failure.
    Result<bool> reference(std::size_t scene, SceneInfo& info, double& seconds,
                           const std::function<void(const WorkProgress&)>& progress);
    /// experiments::run_cell(); a cell whose process died or was timed out has failed, and its checkpoint stays.
    Result<CellOutcome> run_cell(const PlannedCell& planned, double seconds_per_sample,
                                 const std::function<void(const WorkProgress&)>& progress);
    /// Until the last cell is safe on disk.
    Status close();

    /// Whether the last question was answered by the death of who was asked.
    [[nodiscard]] bool died() const { return died_; }
    /// Wall seconds within renderers: loading, building, preparing, rendering.
    [[nodiscard]] double seconds() const { return seconds_; }

  private:
    Result<Json> ask(const Json& request, double timeout, double seconds_to_stop,
                     const std::function<void(const WorkProgress&)>& progress);
    Status finish_last();
    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(); }

    const ExperimentConfig& config_;
    std::string directory_;
    const std::atomic<bool>* stop_;
    std::optional<ChildProcess> process_;  ///< none: `here_` answers
    Responder here_;
    double seconds_ = 0;
    bool died_ = false;
    std::optional<Cell> last_;  ///< the cell that was finished last, perhaps not yet under its name
};

}  // namespace raylex::experiments
