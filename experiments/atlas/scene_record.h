// What a scene can produce, as an atlas carries it: so that expressions asked for afterwards are planned, proved and
// warned about as the render would have done.
#pragma once

#include <string>

#include "experiments/job/channels/scene_words.h"

namespace raylex::experiments {

/// As JSON.
std::string scene_record(const SceneWords& scene);
/// Errors name `path`: no such record.
Result<SceneWords> read_scene_record(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
