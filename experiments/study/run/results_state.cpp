#include "experiments/study/run/results_state.h"

#include <fcntl.h>
#include <unistd.h>
#include <utility>

#include "display/services/parameters.h"
#include "experiments/program/work_lock.h"

namespace raylex::experiments {

Error directory_error(const std::string& path, std::string message, std::string hint) {
    return error_at({path, 0, 0}, std::move(message), std::move(hint));
}

Status check_same_config(const Experiment& results, const ExperimentConfig& config) {
    if (results.config_hash == config.hash) return success();
    std::string there;
    for (const std::string& each : results.overrides) there += " --set " + each;
    return error_at({config.file, 1, 1},
                    "the results in '" + results.directory + "' belong to another config: hash " + results.config_hash +
                        (there.empty() ? "" : " (with" + there + ")") + ", this one has " + config.hash,
                    "choose another directory with -o, or use the config and --set of the results");
}

DirectoryLock::~DirectoryLock() {
    if (file_ >= 0) close(file_);
}

void DirectoryLock::leave_to_parent() {
    if (file_ >= 0) close(file_);
    file_ = -1;
}

Status DirectoryLock::take(const std::string& directory, const std::string& name) {
    const std::string path = directory + "/" + name;
    file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    // On file systems without locks, the user must make sure that only one run uses the directory.
    if (file_ < 0 || lock_file(file_)) return success();
    return directory_error(directory, "another process is running cells into this directory",
                           "wait for it, or choose another directory with -o");
}

}  // namespace raylex::experiments
