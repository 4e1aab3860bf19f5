// A record of the paths that a scene can produce, stored in an atlas, so that later expressions get the same plans,
// proofs and warnings as in the render.
#pragma once

#include <string>

#include "experiments/job/channels/scene_path_strings.h"

namespace raylex::experiments {

/// Returns the record as JSON.
std::string scene_record(const ScenePathStrings& scene);
/// Parses a record. Errors name `path`: the text is not such a record.
Result<ScenePathStrings> read_scene_record(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
