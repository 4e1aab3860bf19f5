// Plans the channels and partitions of a render. Partitions are proved on automata before a ray is traced.
#pragma once

#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"
#include "display/services/channel.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct ChannelPlan {
    std::vector<display::ChannelDefinition> channels;       ///< for ChannelSettings::list
    std::vector<display::PartitionDeclaration> partitions;  ///< proved partitions, for the file's header
    std::vector<std::string>
        notes;  ///< notes for the user before the render: why there is no `rest` layer, channels without paths
    std::vector<std::string> beauties;  ///< expression channels that accept every path of the scene
    std::string refuted;                ///< not empty: a declared partition does not hold; has the counterexample
};

/// Makes the layers, in this order: the job's expressions, automatic or declared rest layers, the shipped partition,
/// light groups, geometric AOVs. Errors: duplicate or invalid names, expressions that do not parse, unknown AOVs or
/// channels, partitions of channels with prefixes. A partition that does not hold is not an Error; it sets `refuted`.
Result<ChannelPlan> plan_channels(const Job& job, const ScenePathStrings& scene);

/// Adds what a denoiser needs to the plan and the job: the variance of the beauty and of all layers in partitions, and
/// albedo and normals with theirs.
Status add_denoiser_inputs(const ScenePathStrings& scene, ChannelPlan& plan, Job& job);

}  // namespace raylex::experiments
