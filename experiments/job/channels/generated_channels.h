// The channels that a job gets by one setting: the shipped partition, light groups, layers by technique.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "transport/render/render.h"

namespace raylex::experiments {

std::vector<ExpressionRequest> shipped_channels();

/// Returns one channel per light group, and light_default for light without a group.
std::vector<ExpressionRequest> light_group_channels(const transport::SceneAlphabet& alphabet);

/// A layer of a channel: its name is CHANNEL_suffix, its expression prefix;EXPRESSION.
struct TechniqueLayer {
    std::string suffix, prefix;
    bool weighted = true;
};
/// Returns a layer per technique, weighted and unweighted, for words of up to 8 vertices, and one layer for longer
/// words. The weighted layers sum to the channel by construction, because each contribution has one technique.
std::vector<TechniqueLayer> technique_layers(std::optional<int> max_depth);

}  // namespace raylex::experiments
