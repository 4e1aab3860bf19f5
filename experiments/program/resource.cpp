#include "experiments/program/resource.h"

#include <dlfcn.h>

#include <filesystem>

#include "display/services/parameters.h"

namespace raylex::experiments {

Result<std::string> resource(const std::string& name) {
    namespace fs = std::filesystem;
    std::error_code failed;
    const fs::path program = fs::read_symlink("/proc/self/exe", failed).parent_path();
    // This code is in Python's module if the program is Python: PREFIX/lib/pythonX.Y/dist-packages/raylex when
    // installed, python/raylex in a build folder.
    Dl_info own{};
    fs::path module = program;
    if (dladdr(reinterpret_cast<const void*>(&resource), &own) != 0)
        module = fs::weakly_canonical(own.dli_fname, failed).parent_path();
    const fs::path beside = module.parent_path().parent_path(), prefix = beside.parent_path().parent_path();
    const fs::path data = fs::path(RAYLEX_DATA_FOLDER) / name, library = fs::path(RAYLEX_LIBRARY_FOLDER) / name;
    const fs::path installed = program.parent_path() / data, installed_library = program.parent_path() / library;
    for (const fs::path& found :
         {program / name, installed, installed_library, module / name, beside / name, prefix / data, prefix / library})
        if (fs::exists(found, failed)) return found.string();
    const bool is_library = fs::path(name).extension() == ".so";
    return error_at({(is_library ? installed_library : installed).string(), 0, 0},
                    "this part of raylex is missing, also beside the program; expected the whole installation or clone "
                    "where the program is: move it too, or build or install raylex again");
}

}  // namespace raylex::experiments
