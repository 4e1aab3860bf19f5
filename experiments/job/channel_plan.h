// Which channels a render gets and which of them partition what, proved on the automata before a ray is traced.
#pragma once

#include <string>
#include <vector>

#include "display/output/exr_writer.h"
#include "display/services/channel.h"
#include "experiments/job/job.h"
#include "lpe/result.h"
#include "lpe/words.h"
#include "transport/render/render.h"

namespace raylex::experiments {

struct ChannelPlan {
    std::vector<display::ChannelDefinition> channels;       ///< for RenderSettings::channels
    std::vector<display::PartitionDeclaration> partitions;  ///< proved ones, for the file's header
    std::vector<std::string>
        notes;            ///< what a user should know before the render: no `rest` layer and why, dead channels
    std::string refuted;  ///< not empty: a declared partition is none; says which path shows it
};

/// The words of W that the scene can produce, for proofs.
lpe::Words words_of(const transport::SceneAlphabet& alphabet);

/// Layers, in order: the job's expressions, the automatic or declared rest layers, the shipped partition, light groups,
/// geometric AOVs. Errors: names used twice or not usable, expressions that do not parse, unknown AOVs or channels,
/// partitions of channels that have prefixes. A partition that does not hold is no Error but `refuted`.
Result<ChannelPlan> plan_channels(const Job& job, const transport::SceneAlphabet& alphabet);

}  // namespace raylex::experiments
