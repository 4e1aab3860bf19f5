#include "experiments/cli/studies/experiment_merge.h"

#include <filesystem>
#include <set>

#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/work_lock.h"
#include "experiments/study/report/study_report.h"
#include "experiments/study/results.h"
#include "experiments/study/run/merge.h"
#include "experiments/study/run/results_state.h"
#include "experiments/study/run/run_marks.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Returns the lock file of the run with this finished_file().
std::string run_lock(const std::string& finished) {
    const std::string directory = fs::path(finished).parent_path().string();
    const auto mark = begun_mark(directory);
    return directory + "/.running" + (mark && mark->shard.parts > 1 ? "-" + std::to_string(mark->shard.part) : "");
}

/// Returns the directories of --shards. Errors: a shard is not finished.
Result<std::vector<std::string>> finished_shards(const ExperimentMergeOptions& options) {
    if (options.directories.size() != 1)
        return error_at({"--shards", 0, 0},
                        "--shards with several directories; expected one with subdirectories 1 to " +
                            std::to_string(options.shards) + " in it");
    std::vector<std::string> directories, files;
    for (unsigned part = 1; part <= options.shards; ++part) {
        directories.push_back(options.directories.front() + "/" + std::to_string(part));
        files.push_back(finished_file(directories.back()));
    }
    constexpr double patience = 10;  // seconds; the process of a shard takes its lock sooner
    if (Status all = wait_for_files(files, run_lock, options.wait ? patience : 0); !all) return all.error();
    return directories;
}

/// Warns of cells with a time budget on different kinds of machines, because their errors are not comparable.
void warn_of_machines(const Experiment& results) {
    std::set<std::string> machines;
    for (const StudyRun& each : results.runs)
        if (each.budget_kind == BudgetKind::seconds && !each.machine.empty()) machines.insert(each.machine);
    if (machines.size() < 2) return;
    std::string list;
    for (const std::string& each : machines) list += "\n  " + each;
    print_warning("cells with a budget in seconds ran on " + std::to_string(machines.size()) +
                  " kinds of machines, so their errors are not comparable:" + list);
}

/// Merges into a temporary directory and renames it at the end, so that an earlier merge survives every failure.
Result<MergeOutcome> merge_whole(const std::vector<std::string>& directories, const ExperimentMergeOptions& options) {
    std::error_code failed;
    if (!options.replace || (fs::exists(options.output, failed) && !fs::exists(options.output + "/experiment.json")))
        return merge_experiments(directories, options.output);
    const std::string partial = options.output + ".partial", old = options.output + ".replaced";
    fs::remove_all(partial, failed);
    auto outcome = merge_experiments(directories, partial);
    if (!outcome) return outcome;
    fs::remove_all(old, failed);
    if (fs::exists(options.output, failed)) fs::rename(options.output, old, failed);
    if (!failed) fs::rename(partial, options.output, failed);
    if (failed)
        return directory_error(options.output, "cannot rename '" + partial + "' to this name: " + failed.message());
    fs::remove_all(old, failed);
    return outcome;
}

}  // namespace

int merge_study(const ExperimentMergeOptions& options) {
    std::vector<std::string> directories = options.directories;
    if (options.shards > 0) {
        auto finished = finished_shards(options);
        if (!finished) return report_error(finished.error());
        directories = *std::move(finished);
    }
    auto outcome = merge_whole(directories, options);
    if (!outcome) return report_error(outcome.error());
    print_line(options.output + ": " + std::to_string(outcome->done) + " cells done, " +
               std::to_string(outcome->failed) + " failed, " + std::to_string(outcome->missing) + " not run yet");
    auto results = read_experiment(options.output);
    if (!results) return report_error(results.error());
    warn_of_machines(*results);
    return options.report ? write_study_report(*results) : exit_holds;
}

}  // namespace raylex::experiments
