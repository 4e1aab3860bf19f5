// Runs everything that may crash in a separate process: loading, calibration, references, cells. After a crash a new
// process starts, which loads what it needs again.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiments/job/text/json_fields.h"
#include "experiments/study/run/cells/run_renderer.h"
#include "experiments/study/run/processes/child_process.h"
#include "experiments/study/run/workers/worker_service.h"

namespace raylex::experiments {

/// The properties of a scene that are known after loading.
struct DescribedScene {
    SceneInfo info;  ///< hash, size, channels
    std::vector<PartitionInfo> partitions;
};

/// A short render whose image is discarded.
struct Calibration {
    double setup_seconds = 0;  ///< the integrator's preparation, independent of the number of samples
    double seconds = 0, samples = 0, relative_error = -1;  ///< of rendering; samples per pixel
    std::vector<std::string> warnings;
    std::uint64_t peak_memory_bytes = 0;
};
RAYLEX_JSON_FIELDS(Calibration, setup_seconds, seconds, samples, relative_error, warnings, peak_memory_bytes)

class RunWorker {
  public:
    /// `config` and `plan` must outlive this object and must not change after the first call. `isolated`: false runs
    /// everything in this process. `in_process` is called first in every new process.
    RunWorker(const ExperimentConfig& config, const Plan& plan, std::string directory, const std::atomic<bool>* stop,
              bool isolated, std::function<void()> in_process = {});

    Result<DescribedScene> describe(std::size_t scene, std::size_t variant);
    Result<std::uint64_t> frame_buffer_bytes(std::size_t scene, std::size_t variant);
    /// Returns reason_of_scene() of run_parts.h; empty if the scene cannot be loaded, which its cells report.
    std::string reason_to_keep(std::size_t scene, std::size_t variant);
    Result<Calibration> calibrate(std::size_t scene, std::size_t variant);
    /// Calls provide_reference(). A crash or failed render is reported in info.reference_failure.
    Result<bool> reference(std::size_t scene, SceneInfo& info, double& seconds,
                           const std::function<void(const WorkProgress&)>& progress);
    /// Calls experiments::render_run(). A cell whose process crashed or timed out has failed; its checkpoint stays.
    Result<RenderedRun> render_run(const PlannedRun& planned, double seconds_per_sample,
                                   const std::function<void(const WorkProgress&)>& progress);
    /// Waits until the last cell is safely on disk.
    Status close();

    /// Returns whether the process crashed during the last request.
    [[nodiscard]] bool died() const { return died_; }
    /// Wall seconds in renderers: loading, building, preparing, rendering.
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
    std::optional<StudyRun> last_;  ///< the last finished cell, perhaps before its rename
};

}  // namespace raylex::experiments
