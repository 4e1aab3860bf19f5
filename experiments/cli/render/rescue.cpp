#include "experiments/cli/render/rescue.h"

#include <filesystem>
#include <utility>

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Returns `wanted` if no such file exists, else the first free name of "NAME.2.exr" and so on, so that files of
/// earlier renders stay. Returns an empty string if all names are taken.
std::string unused_name(const fs::path& wanted) {
    constexpr int most = 1000;
    fs::path path = wanted;
    std::error_code failed;
    for (int number = 2; number < most && fs::exists(path, failed); ++number)
        path = wanted.parent_path() /
               (wanted.stem().string() + "." + std::to_string(number) + wanted.extension().string());
    return fs::exists(path, failed) ? std::string() : path.string();
}

}  // namespace

Error rescued(Error failure, const std::string& what, const std::string& path,
              const std::function<Status(const std::string& path)>& write) {
    std::error_code failed;
    const fs::path folder = fs::temp_directory_path(failed);
    const std::string other = failed ? std::string() : unused_name(folder / fs::path(path).filename());
    const bool saved = !other.empty() && write(other);
    if (!failure.hint.empty()) failure.hint += "\n";
    failure.hint += saved ? what + " was saved as " + other + " instead"
                          : what + " could not be saved in the folder for temporary files ($TMPDIR) either";
    return failure;
}

}  // namespace raylex::experiments
