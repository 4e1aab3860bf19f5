// Notes for the user about a channel before the render: why it matches no path of this scene, and which labels of its
// expression nothing in the scene has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/job/channels/scene_path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns a sentence for each label of the expression that nothing in the scene has in that role, with the closest
/// match if there is one: "'flor' is not a known object label of this scene; did you mean 'floor'?"
Result<std::vector<std::string>> unknown_labels(const lpe::ChannelSource& channel, const ScenePathStrings& scene);

/// Returns nothing if a path of the scene matches. Otherwise returns the reason, derived from the shortest path that
/// would match if the scene had more objects, lobes, lights, media or depth: "it needs light of the group 'kee', and
/// ...".
Result<std::optional<std::string>> why_never(const lpe::ChannelSource& channel, const ScenePathStrings& scene);

}  // namespace raylex::experiments
