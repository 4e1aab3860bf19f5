// Renders one cell, from its plan to its directory, or one reference.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "experiments/study/plan/plan.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/scene_store.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// The progress of the current render. `error` is relative, negative while unknown.
struct WorkProgress {
    double share = 0, seconds = 0, error = -1;
    int process_group = 0;  ///< of an external command in progress
};

struct WorkContext {
    const ExperimentConfig& config;
    const Plan& plan;
    SceneStore& scenes;
    std::string directory;  ///< results directory
    std::function<void(const WorkProgress&)> progress;
    const std::atomic<bool>* stop = nullptr;
    RunCloser* closer = nullptr;  ///< null only if no cells run
};

/// The result of a cell: done, failed, or stopped by an interrupt, perhaps with a checkpoint.
struct RenderedRun {
    StudyRun run;
    bool stopped = false;
    double relative_error = -1;  ///< as estimated by the render; negative: unknown
    double outside_seconds = 0;  ///< wall seconds in an external renderer
};

/// Renders into cells/ID.partial, which the closer renames to cells/ID, or writes failed/ID.json. `seconds_per_sample`
/// is the expected time per sample of the whole image, 0 if unknown. Errors end the experiment: the disk rejects files
/// of this cell or the previous one, or a checkpoint is damaged or belongs to another program. A render that fails is
/// not an Error but a failed cell.
Result<RenderedRun> render_run(const WorkContext& context, const PlannedRun& planned, double seconds_per_sample);

/// Writes failed/ID.json and removes the cell's directory, entirely or except its checkpoint. Errors end the
/// experiment.
Result<RenderedRun> record_failure(const std::string& results, RenderedRun outcome, const Error& reason,
                                   bool keep_checkpoint);
/// Returns the checkpoint file of a cell or reference in its partial directory.
std::string checkpoint_file(const std::string& partial);

/// Renders the same pixels again, without files, to compare bits.
Result<Rendered> render_again(const WorkContext& context, const PlannedRun& planned, const StudyRun& done);

/// Makes the scene's reference, or finds an existing one, and sets the scene's fields. Does nothing if the config
/// requests no reference; returns false after an interrupt. Adds its time to `seconds`. A failed render is reported in
/// `info.reference_failure`; Errors concern imported images, damaged files and disks.
Result<bool> provide_reference(const WorkContext& context, std::size_t scene, SceneInfo& info, double& seconds);

}  // namespace raylex::experiments
