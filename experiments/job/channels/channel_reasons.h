// What a user should know of a channel before the render: that it can match nothing here and why, and labels of its
// expression that nothing in the scene has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/job/channels/scene_words.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Labels of the expression that nothing in the scene has where the expression asks for them, each with a near miss
/// when there is one: "'flor' is no object label of this scene; did you mean 'floor'?"
Result<std::vector<std::string>> unknown_labels(const lpe::ChannelSource& channel, const SceneWords& scene);

/// Nothing when some path of the scene matches, else why none does, told by the shortest path that would match if the
/// scene had more objects, lobes, lights, media or depth: "it needs light of the group 'kee', and ...".
Result<std::optional<std::string>> why_never(const lpe::ChannelSource& channel, const SceneWords& scene);

}  // namespace raylex::experiments
