// Makes layers from an atlas for the channels of a job, for raylex ask and Python's Atlas.ask.
#pragma once

#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "display/output/writer/exr_writer.h"
#include "experiments/atlas/requested_layers.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct AtlasAnswer {
    RequestedLayers layers;
    display::ImageDescription description;  ///< the render's, with the requested partitions that are exact
    std::vector<std::string> notes;         ///< notes for the user
    std::string refuted;                    ///< not empty: a declared partition does not hold, and there are no layers
};

/// Makes layers for the expressions, partitions and light groups of `job` from the words of the atlas; ignores the
/// job's other settings. Errors: those of plan_channels() and RequestedLayers::make(); an atlas without a record of its
/// scene.
Result<AtlasAnswer> answer_question(display::AtlasFile& atlas, const Job& job, const AskSettings& settings);

}  // namespace raylex::experiments
