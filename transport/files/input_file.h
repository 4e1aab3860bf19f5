// Reads whole files into memory, gzip-compressed or not, and finds a scene's relative file names.
#pragma once

#include <filesystem>
#include <string>

#include "display/services/parameters.h"
#include "lpe/input/read_input.h"

namespace raylex::transport {

/// The content of `path`, decompressed when it starts with gzip's magic number. Errors name the path and the system's
/// reason; a gzip stream that ends early, fails its checksum or unpacks to more than the budgets allow is an Error.
Result<std::string> read_file(const std::string& path, NamedBy by = NamedBy::file,
                              const std::string& expected = "a file");

/// The folders in which scene files are searched. pbrt searches the folder of the top-level scene. The folder of the
/// file that contains the name comes second, so that a subfolder can also be moved as a whole.
struct SearchPath {
    std::filesystem::path scene_folder, local_folder;

    /// The absolute path of the existing file `name`, or an Error at `where` that lists the folders searched.
    [[nodiscard]] Result<std::string> find(const std::string& name, const SourceLocation& where) const;
};

}  // namespace raylex::transport
