// Which channels a render gets and which of them partition what, proved on the automata before a ray is traced.
#pragma once

#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"
#include "display/services/channel.h"
#include "experiments/job/channels/scene_words.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct ChannelPlan {
    std::vector<display::ChannelDefinition> channels;       ///< for ChannelSettings::list
    std::vector<display::PartitionDeclaration> partitions;  ///< proved ones, for the file's header
    std::vector<std::string>
        notes;  ///< what a user should know before the render: no `rest` layer and why, dead channels
    std::vector<std::string>
        beauties;         ///< expression channels that take every path of the scene, however they are written
    std::string refuted;  ///< not empty: a declared partition is none; says which path shows it
};

/// Layers, in order: the job's expressions, the automatic or declared rest layers, the shipped partition, light groups,
/// geometric AOVs. Errors: names used twice or not usable, expressions that do not parse, unknown AOVs or channels,
/// partitions of channels that have prefixes. A partition that does not hold is no Error but `refuted`.
Result<ChannelPlan> plan_channels(const Job& job, const SceneWords& scene);

}  // namespace raylex::experiments
