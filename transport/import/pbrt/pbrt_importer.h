// Reads pbrt-v4 scene files as they are.
//
// All directives are supported; Accelerator has no effect, and Option little. Relative file names are searched in the
// folder of the top-level scene, as pbrt does, then beside the file that contains them; all files may be
// gzip-compressed. Quadrilaterals of a plymesh stay bilinear patches as in pbrt. Area lights inside ObjectBegin emit
// nothing and add a warning.
#pragma once

#include <string>

#include "lpe/result.h"
#include "transport/scene/loading_progress.h"
#include "transport/scene/missing_files.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct ImportOptions {
    MissingFiles missing = MissingFiles::refused;
    int threads = 0;                      ///< that read meshes; 0 = all
    LoadingProgress* progress = nullptr;  ///< receives progress, unless null
};

/// Parses `path` with all files that it includes, and loads its meshes. Errors name file, line, column and what was
/// expected. Input that would make the image wrong is an error; an unknown harmless directive or parameter is a
/// warning.
Result<SceneDescription> import_pbrt(const std::string& path, const ImportOptions& options = {});
/// Imports text from memory like import_pbrt(); relative file names are searched beside `virtual_path`.
Result<SceneDescription> import_pbrt_text(const std::string& text, const std::string& virtual_path,
                                          const ImportOptions& options = {});

}  // namespace raylex::transport
