// Reads pbrt-v4 scene files as they are.
//
// Every directive is understood; Accelerator has nothing to say here, and Option little. Relative file names are looked
// up in the folder of the top-level scene, as pbrt does, then beside the file that holds them; all files may be
// gzip-compressed. Quadrilaterals of a plymesh stay bilinear patches as in pbrt. Area lights inside ObjectBegin stay
// dark, with a warning.
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
    LoadingProgress* progress = nullptr;  ///< told of what is read, if any
};

/// Parses `path` with everything it includes and loads its meshes. Errors name file, line, column and what was
/// expected; what would make the image wrong is an error, an unknown harmless directive or parameter a warning.
Result<SceneDescription> import_pbrt(const std::string& path, const ImportOptions& options = {});
/// The same for text in memory; relative file names are looked up beside `virtual_path`.
Result<SceneDescription> import_pbrt_text(const std::string& text, const std::string& virtual_path,
                                          const ImportOptions& options = {});

}  // namespace raylex::transport
