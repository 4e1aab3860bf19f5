// A question to an atlas, from what a job asks for to an image: what raylex ask and Python's Atlas.ask do.
#pragma once

#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "display/output/writer/exr_writer.h"
#include "experiments/atlas/asked_layers.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct AtlasAnswer {
    AskedLayers layers;
    display::ImageDescription description;  ///< the render's, with the partitions that were asked for and are exact
    std::vector<std::string> notes;         ///< what a user should know
    std::string refuted;                    ///< not empty: a declared partition is none, and there are no layers
};

/// Expressions, partitions and light groups of `job` by the words of the atlas; what else a job has is not looked at.
/// Errors: those of plan_channels() and of AskedLayers::make(); an atlas that does not say what its scene can produce.
Result<AtlasAnswer> answer_question(display::AtlasFile& atlas, const Job& job, const AskSettings& settings);

}  // namespace raylex::experiments
