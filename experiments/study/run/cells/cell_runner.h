// One cell from its plan to its directory, and one reference likewise.
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

/// How far the render at hand is. `error` is relative, negative while it is not known.
struct WorkProgress {
    double share = 0, seconds = 0, error = -1;
    int process_group = 0;  ///< of an external command that is being waited for
};

struct WorkContext {
    const ExperimentConfig& config;
    const Plan& plan;
    SceneStore& scenes;
    std::string directory;  ///< of the results
    std::function<void(const WorkProgress&)> progress;
    const std::atomic<bool>* stop = nullptr;
    CellCloser* closer = nullptr;  ///< null only where no cells are run
};

/// What became of a cell: done, failed, or stopped by an interrupt, of which a checkpoint may be left.
struct CellOutcome {
    Cell cell;
    bool stopped = false;
    double relative_error = -1;  ///< by the render's own estimate; negative: not known
    double outside_seconds = 0;  ///< wall, within an external renderer
};

/// Renders into cells/ID.partial and has the closer rename that to cells/ID, or writes failed/ID.json.
/// `seconds_per_sample` is what a sample of the whole image is expected to take, 0 when not known. Errors end the
/// experiment: a disk that takes nothing, be it of this cell or of the one before, a checkpoint that is damaged or of
/// another program. A render that cannot be done is no Error but a failed cell.
Result<CellOutcome> run_cell(const WorkContext& context, const PlannedCell& planned, double seconds_per_sample);

/// Writes failed/ID.json and removes the cell's directory, all of it or all but its checkpoint. Errors end the
/// experiment.
Result<CellOutcome> record_failure(const std::string& results, CellOutcome outcome, const Error& reason,
                                   bool keep_checkpoint);
/// Of a cell's directory or a reference's, while it is partial.
std::string checkpoint_file(const std::string& partial);

/// The same pixels again, without files: for comparing bits.
Result<Rendered> render_again(const WorkContext& context, const PlannedCell& planned, const Cell& done);

/// Makes the scene's reference, or finds it: sets the scene's fields. Nothing when the config asks for none; false when
/// an interrupt came first. `seconds` is increased by what it took. A render that cannot be done is told in
/// `info.reference_failure`; Errors are of images from elsewhere, of damaged files and of disks.
Result<bool> provide_reference(const WorkContext& context, std::size_t scene, SceneInfo& info, double& seconds);

}  // namespace raylex::experiments
