// Reads pbrt-v4 scene files as they are.
#pragma once

#include <string>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Parses `path` with everything it includes and loads its meshes. Errors name file, line, column and what was expected;
/// what would make the image wrong (media, for now) is an error, an unknown harmless directive or parameter a warning.
Result<SceneDescription> import_pbrt(const std::string& path);
/// The same for text in memory; relative file names are looked up beside `virtual_path`.
Result<SceneDescription> import_pbrt_text(const std::string& text, const std::string& virtual_path);

}  // namespace raylex::transport
