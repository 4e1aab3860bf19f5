// One cell's samples over several runs: which parts a cell has, what a part leaves on disk, and the cell made of its
// parts.
//
// A part is a shard of the render (transport::SampleSettings::first): whole blocks of the frame buffer's
// canonical summation, so that sums of parts are, bit for bit, those of the whole (Law 3). It is cells/ID.pKofN with
// cell.json and record.bin.
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
    std::vector<PlannedCell> items;  ///< cells and parts in the order of the plan, the parts of a cell in turn
    std::vector<std::string> notes;  ///< which cells are kept whole, and why
};

/// Why cells of a scene by a variant of this program are kept whole; empty when they can be split.
std::string reason_of_scene(const ExperimentConfig& config, std::size_t scene, std::size_t variant, SceneStore& scenes);

/// Asked for a scene and a variant: what reason_of_scene() says.
using ReasonToKeep = std::function<std::string(std::size_t scene, std::size_t variant)>;

/// The plan with each cell in `split` parts of about as many samples; fewer where it has fewer blocks of samples. Kept
/// whole: cells whose samples are found on the way (budgets of time and error), those of external commands, of Markov
/// chains, with cryptomattes, and of one block.
WorkList split_cells(const ExperimentConfig& config, const Plan& plan, const ReasonToKeep& reason_to_keep,
                     unsigned split);

/// record.bin of a part: its sums, and what the image of the whole cell will say of itself.
Status write_part_record(const std::string& directory, const Rendered& rendered, const JobScene& scene,
                         const std::map<std::string, std::string>& attributes);

/// Whether these are all parts of the cell, each once and with its seed; sorts them by their samples. Errors name the
/// part that is missing, there twice, or shares samples with another.
Status check_parts(const Cell& cell, std::vector<const Cell*>& parts);

/// The cell that its parts come to: times and counts are sums, memory is the largest.
Cell merged_cell(const Cell& planned, const std::vector<const Cell*>& parts);

/// The files of the whole cell, into a directory that is there, from those of its sorted parts.
Result<std::vector<PartitionVerdict>> write_merged_files(const std::string& directory, const Cell& cell,
                                                         const std::vector<const Cell*>& parts);

}  // namespace raylex::experiments
