#include "experiments/cluster/study_commands.h"

#include <algorithm>
#include <map>
#include <set>
#include <thread>

#include "experiments/program/console.h"
#include "experiments/study/run/cells/run_parts.h"
#include "experiments/study/run/run_marks.h"
#include "experiments/study/run/workers/estimates.h"
#include "experiments/study/run/workers/run_worker.h"

namespace raylex::experiments {
namespace {

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string>& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

bool has_references(const ExperimentConfig& config) {
    return !config.reference.method.empty() ||
           std::any_of(config.scenes.begin(), config.scenes.end(),
                       [](const SceneRequest& each) { return !each.reference_file.empty(); });
}

/// Estimates the requirements of a study by a short render of every scene with every variant.
class StudySurvey {
  public:
    StudySurvey(const ExperimentConfig& config, const StudyCommandsRequest& request, const std::atomic<bool>* stop)
        : config_(config), request_(request), stop_(stop), estimates_(config) {}

    Status look() {
        auto plan = make_plan(config_);
        if (!plan) return plan.error();
        plan_ = std::move(*plan);
        RunWorker worker(config_, plan_, request_.directory, stop_, true);
        std::set<std::size_t> broken;
        std::optional<Error> first;
        for (const PlannedRun& each : plan_.runs) {
            if (stop_ != nullptr && stop_->load()) return success();
            if (broken.contains(each.scene) || !seen_.emplace(each.scene, each.variant).second) continue;
            auto bytes = worker.frame_buffer_bytes(each.scene, each.variant);
            if (bytes) {
                image_bytes_ = std::max(image_bytes_, *bytes);
                continue;
            }
            broken.insert(each.scene);
            if (!first) first = bytes.error();
        }
        if (broken.size() == config_.scenes.size() && first) return *first;
        if (request_.calibrate) static_cast<void>(estimates_.calibrate(worker, plan_, broken, stop_));
        work_ = split_runs(
            config_, plan_,
            [&](std::size_t scene, std::size_t variant) { return worker.reason_to_keep(scene, variant); },
            request_.split_runs);
        if (request_.shards > work_.items.size())
            return error_at({"--shards", 0, 0},
                            std::to_string(request_.shards) + " shards of " + counted(work_.items.size(), "cell") +
                                (request_.split_runs > 1 ? " and parts of cells" : "") +
                                "; expected at most as many shards",
                            "--split-cells N divides a cell into several parts");
        return success();
    }

    [[nodiscard]] std::vector<std::string> notes() const {
        std::vector<std::string> notes = plan_.notes;
        notes.insert(notes.end(), work_.notes.begin(), work_.notes.end());
        return notes;
    }

    /// Sets memory, CPU seconds and whether the command must run alone on its machine.
    void describe(unsigned part, PlannedCommand& command) const {
        const Shard shard{part, request_.shards, request_.split_runs};
        double seconds = 0;
        bool known = true;
        for (std::size_t i = 0; i < work_.items.size(); ++i) {
            if (!shard.has(i)) continue;
            command.exclusive = command.exclusive || work_.items[i].run.budget_kind == BudgetKind::seconds;
            const auto one = estimates_.seconds(work_.items[i]);
            seconds += one.value_or(0);
            known = known && one;
        }
        command.cores = cores();
        command.memory_bytes = memory();
        if (known) command.cpu_seconds = seconds * cores_here();
    }

    void describe_references(PlannedCommand& command) const {
        double seconds = 0;
        bool known = true;
        for (std::size_t i = 0; i < config_.scenes.size(); ++i) {
            if (!config_.scenes[i].reference_file.empty()) continue;
            const auto one = estimates_.reference_seconds(i);
            seconds += one.value_or(0);
            known = known && one;
        }
        command.cores = cores();
        command.memory_bytes = memory();
        if (known) command.cpu_seconds = seconds * cores_here();
    }

    /// Returns the peak memory of the test renders, plus two copies of the image: for a checkpoint and for writing.
    [[nodiscard]] std::uint64_t memory() const {
        return estimates_.peak_memory_bytes() > 0 ? estimates_.peak_memory_bytes() + 2 * image_bytes_ : 0;
    }

  private:
    /// Number of cores of a shard on its machine. cores_here() is the number of cores of the test render.
    [[nodiscard]] unsigned cores() const { return request_.threads > 0 ? request_.threads : cores_here(); }
    [[nodiscard]] unsigned cores_here() const {
        const int threads = config_.base.settings.machine.threads;
        return threads > 0 ? static_cast<unsigned>(threads) : std::max(1U, std::thread::hardware_concurrency());
    }

    const ExperimentConfig& config_;
    const StudyCommandsRequest& request_;
    const std::atomic<bool>* stop_;
    Estimates estimates_;
    Plan plan_;
    WorkList work_;
    std::set<std::pair<std::size_t, std::size_t>> seen_;
    std::uint64_t image_bytes_ = 0;
};

PlannedCommand reference_command(const StudyCommandsRequest& request, const StudyFolders& folders,
                                 const StudySurvey& survey) {
    PlannedCommand command;
    command.name = "references";
    command.arguments =
        joined(joined({program_path(), "experiment", "run"}, request.config),
               {"-o", folders.reference_run, "--references", folders.references, "--only-references", "--resume"});
    if (request.retry) command.arguments.push_back("--retry");
    command.target = finished_file(folders.reference_run);
    survey.describe_references(command);
    return command;
}

PlannedCommand shard_command(const StudyCommandsRequest& request, const StudyFolders& folders,
                             const StudySurvey& survey, unsigned part) {
    PlannedCommand command;
    const std::string shards = std::to_string(request.shards), number = std::to_string(part);
    command.name = "shard-" + number + "-of-" + shards;
    command.arguments = joined(
        joined({program_path(), "experiment", "run"}, request.config),
        {"-o", folders.part(part), "--shard", number + "/" + shards, "--references", folders.references, "--resume"});
    if (request.split_runs > 1)
        command.arguments = joined(command.arguments, {"--split-cells", std::to_string(request.split_runs)});
    if (request.threads > 0)
        command.arguments = joined(command.arguments, {"--threads", std::to_string(request.threads)});
    if (request.retry) command.arguments.push_back("--retry");
    command.target = finished_file(folders.part(part));
    survey.describe(part, command);
    return command;
}

}  // namespace

StudyFolders::StudyFolders(const std::string& directory)
    : references(directory + "/references"),
      reference_run(directory + "/parts/references"),
      parts(directory + "/parts"),
      results(directory + "/results") {}

Result<CommandPlan> study_commands(const ExperimentConfig& config, const StudyCommandsRequest& request,
                                   const std::atomic<bool>* stop) {
    StudySurvey survey(config, request, stop);
    if (Status seen = survey.look(); !seen) return seen.error();
    const StudyFolders folders(request.directory);
    CommandPlan plan;
    plan.name = job_name(config.name);
    plan.notes = {"Each command can run by itself. Repeated commands skip finished work and resume interrupted work.",
                  "The last command merges the results of the others into " + folders.results};
    for (const std::string& note : survey.notes()) plan.notes.push_back(note);
    std::vector<std::string> first;
    if (has_references(config)) {
        plan.commands.push_back(reference_command(request, folders, survey));
        first.push_back(plan.commands.front().name);
    }
    PlannedCommand merge;
    merge.name = "merge";
    merge.arguments = {
        program_path(), "experiment", "merge", folders.parts,  "--shards", std::to_string(request.shards),
        "--wait",       "--replace",  "-o",    folders.results};
    if (request.report) merge.arguments.push_back("--report");
    merge.target = folders.results + (request.report ? "/report.html" : "/experiment.json");
    merge.memory_bytes = survey.memory();
    for (unsigned part = 1; part <= request.shards; ++part) {
        plan.commands.push_back(shard_command(request, folders, survey, part));
        plan.commands.back().needs = first;
        merge.needs.push_back(plan.commands.back().name);
    }
    plan.commands.push_back(std::move(merge));
    return plan;
}

}  // namespace raylex::experiments
