// Splits a cell's samples over several runs: the parts of a cell, the files of a part, and the merge of parts.
//
// A part is a shard of the render (transport::SampleSettings::first). It consists of whole blocks of the frame
// buffer's canonical summation, so the sums over parts are bit-identical to the whole (Law 3). Its files are
// cells/ID.pKofN with cell.json and record.bin.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "experiments/study/plan/plan.h"
#include "experiments/study/run/cells/scene_store.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct WorkList {
    std::vector<PlannedRun> items;   ///< cells and parts in the order of the plan, parts of a cell in order
    std::vector<std::string> notes;  ///< cells that stay whole, and why
};

/// Returns why the cells of a scene and a variant stay whole; empty if they can be split.
std::string reason_of_scene(const ExperimentConfig& config, std::size_t scene, std::size_t variant, SceneStore& scenes);

/// Returns the result of reason_of_scene() for a scene and a variant.
using ReasonToKeep = std::function<std::string(std::size_t scene, std::size_t variant)>;

/// Splits each cell of the plan into `split` parts of about equal size; fewer if it has fewer blocks of samples. Cells
/// stay whole if their number of samples is not known in advance (budgets of time and error), if they belong to
/// external commands or Markov chains, have cryptomattes, or have one block.
WorkList split_runs(const ExperimentConfig& config, const Plan& plan, const ReasonToKeep& reason_to_keep,
                    unsigned split);

/// Writes record.bin of a part: its sums, and the description of the whole cell's image.
Status write_part_record(const std::string& directory, const Rendered& rendered, const JobScene& scene,
                         const std::map<std::string, std::string>& attributes);

/// Checks that these are all parts of the cell, each once and with its seed, and sorts them by samples. Errors name a
/// part that is missing, duplicate, or shares samples with another.
Status check_parts(const StudyRun& run, std::vector<const StudyRun*>& parts);

/// Returns the cell merged from its parts: times and counts are sums, memory is the maximum.
StudyRun merged_run(const StudyRun& planned, const std::vector<const StudyRun*>& parts);

/// Writes the files of the whole cell into an existing directory, from its sorted parts.
Result<std::vector<PartitionResult>> write_merged_files(const std::string& directory, const StudyRun& run,
                                                        const std::vector<const StudyRun*>& parts);

}  // namespace raylex::experiments
