#include "experiments/study/run/results_state.h"

#include <fcntl.h>
#include <unistd.h>
#include <filesystem>
#include <set>
#include <utility>

#include "display/services/parameters.h"
#include "experiments/program/console.h"
#include "experiments/program/work_lock.h"
#include "experiments/study/file_records.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/run_marks.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Returns whether the directory is empty or has only traces of a run without results: locks, marks and a folder for
/// cells.
bool is_fresh(const std::string& directory) {
    std::error_code failed;
    if (!fs::is_directory(directory, failed)) return false;
    for (const fs::directory_entry& each : fs::directory_iterator(directory, failed)) {
        const std::string name = each.path().filename().string();
        if (!name.starts_with(".running") && !is_run_mark(name) &&
            !(name == "cells" && fs::is_empty(each.path(), failed)))
            return false;
    }
    return true;
}

}  // namespace

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

Result<std::optional<Experiment>> earlier_results(const ExperimentConfig& config, const RunRequest& request,
                                                  const WorkList& work) {
    std::error_code failed;
    const std::string& directory = request.directory;
    if (!fs::exists(experiment_file(directory), failed)) {
        if (request.resume && !request.begin)
            return directory_error(directory, "there are no results to continue: no experiment.json",
                                   "'raylex experiment run' starts a new run");
        if (fs::exists(directory, failed) && !is_fresh(directory))
            return directory_error(
                directory, "this directory is neither empty nor a results directory; expected a new one for -o");
        return std::optional<Experiment>();
    }
    auto results = read_experiment(directory);
    if (!results) return results.error();
    if (Status same = check_same_config(*results, config); !same) return same.error();
    if (!request.resume && !(results->runs.empty() && results->parts.empty()))
        return directory_error(
            directory,
            "there are " + std::to_string(results->runs.size() + results->parts.size()) +
                " finished cells of this config already",
            "'raylex experiment resume' continues; to start again, remove the directory or choose another");
    std::set<std::string> items, settled;
    for (const PlannedRun& each : work.items) items.insert(each.run.id);
    for (const StudyRun& each : results->parts) {
        settled.insert(each.id);
        if (!items.contains(each.id))
            return directory_error(directory, "part '" + each.id + "' does not belong to this run",
                                   "use the --split-cells of the earlier run, or choose another directory with -o");
    }
    for (const StudyRun& each : results->runs) settled.insert(each.id);
    for (const std::string& id : items)
        if (const std::string run = run_directory(directory, id); !settled.contains(id) && fs::exists(run, failed))
            return directory_error(run, "this cell is incomplete: it has no cell.json",
                                   "remove this directory, so that the cell is rendered again; all others are kept");
    return std::optional(std::move(*results));
}

Status set_damaged_aside(Experiment& results) {
    for (auto* list : {&results.runs, &results.parts})
        for (auto run = list->begin(); run != list->end();) {
            const std::string damage = damage_of(*run);
            if (damage.empty()) {
                ++run;
                continue;
            }
            print_warning("cell '" + run->id + "' is damaged and is rendered again: " + damage);
            const std::string aside = results.directory + "/damaged/" + run->id;
            std::error_code failed;
            fs::create_directories(results.directory + "/damaged", failed);
            fs::remove_all(aside, failed);
            fs::rename(run->directory, aside, failed);
            if (failed)
                return directory_error(run->directory,
                                       "cannot move this damaged cell to '" + aside + "': " + failed.message());
            results.missing.push_back(run->id);
            run = list->erase(run);
        }
    return success();
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
