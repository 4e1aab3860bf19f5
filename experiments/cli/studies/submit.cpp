// raylex submit and raylex status: run a study on a queue.
#include <filesystem>
#include <memory>
#include <numeric>

#include "experiments/cli/command_output.h"
#include "experiments/cluster/slurm.h"
#include "experiments/cluster/study_commands.h"
#include "experiments/cluster/study_status.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/program/work_lock.h"
#include "experiments/study/run/run_marks.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

struct SubmitOptions {
    std::string config, directory, form = "slurm";
    std::vector<std::string> overrides, slurm_options;
    unsigned shards = 0, split_runs = 1, cores = 1;
    bool slurm = false, again = false, no_calibration = false, no_report = false;
};

/// Returns success if the directory can be submitted: for the first time, or again if none of its jobs is in the queue.
Status check_first_submission(const SubmitOptions& options, const std::string& directory) {
    auto earlier = read_submission(directory);
    if (!earlier) return earlier.error();
    if (earlier->empty()) return success();
    const Submission& there = earlier->front();
    std::string jobs;
    for (const std::string& id : there.ids()) jobs += (jobs.empty() ? "" : ", ") + id;
    if (!options.again)
        return error_at({directory, 0, 0},
                        "a study was submitted into this directory at " + there.submitted + " (jobs " + jobs + ")",
                        "'raylex status' shows its progress; --again submits the unfinished work if none of its jobs "
                        "is in the queue; or choose another directory with -o");
    auto queue = slurm_queue(there.ids());
    if (!queue) return queue.error();
    if (!queue->empty())
        return error_at({directory, 0, 0},
                        "its jobs are still in the queue: " + queue->begin()->first + " is " + queue->begin()->second,
                        "wait for them, or cancel them: scancel " + jobs);
    if (there.count != options.shards)
        return error_at({"--shards", 0, 0},
                        "it was submitted in " + std::to_string(there.count) + " shards; expected the same number");
    return success();
}

/// Returns the shards that are not finished or have failed cells. Error: a shard was started with another config
/// or number of parts.
Result<std::vector<unsigned>> shards_to_run(const ExperimentConfig& config, const SubmitOptions& options,
                                            const StudyFolders& folders) {
    std::vector<unsigned> wanted;
    for (unsigned part = 1; part <= options.shards; ++part) {
        const auto begun = begun_mark(folders.part(part));
        if (begun && (begun->config_hash != config.hash || begun->shard.parts != options.shards ||
                      begun->shard.split_runs != options.split_runs))
            return error_at({folders.part(part), 0, 0},
                            "this shard belongs to a run of another config, --set, --shards or --split-cells",
                            "choose another directory with -o, or the settings of that run");
        if (!is_done(folders.part(part))) wanted.push_back(part);
    }
    return wanted;
}

int submit(const CLI::App& command, const SubmitOptions& options, const std::vector<std::string>& arguments) {
    install_interrupt_handler();
    if (!options.slurm) return report_error("no queue; expected --slurm");
    if (options.shards == 0)
        return report_error("no number of shards; expected --shards N, the number of tasks that run at once");
    auto config = read_experiment_config(options.config, options.overrides);
    if (!config) return report_error(config.error());
    const std::string directory = absolute_path(options.directory);
    const StudyFolders folders(directory);
    std::error_code failed;
    fs::create_directories(directory, failed);
    if (failed) return report_error(error_at({directory, 0, 0}, "cannot make this directory: " + failed.message()));
    auto lock = WorkLock::take(directory + "/.submitting", "is submitting into this directory");
    if (!lock) return report_error(lock.error());
    if (Status first = check_first_submission(options, directory); !first) return report_error(first.error());
    auto wanted = shards_to_run(*config, options, folders);
    if (!wanted) return report_error(wanted.error());
    if (wanted->empty() && fs::exists(folders.results + "/experiment.json", failed)) {
        print_line(directory + ": all shards are done, and merged to " + folders.results);
        return exit_holds;
    }
    if (wanted->empty()) wanted->push_back(options.shards);  // everything is done, but the array must not be empty
    std::vector<std::string> words =
        standing_alone(command, arguments,
                       {"--slurm", "-o", "--output", "--shards", "--split-cells", "--cores", "--option", "--template",
                        "--again", "--no-calibration", "--no-report"});
    words.erase(words.begin(), words.begin() + 2);  // the program, and "submit"
    const StudyCommandsRequest request{.directory = directory,
                                       .shards = options.shards,
                                       .split_runs = options.split_runs,
                                       .threads = options.cores,
                                       .config = words,
                                       .calibrate = !options.no_calibration,
                                       .report = !options.no_report,
                                       .retry = options.again};
    auto plan = study_commands(*config, request, &interrupt_flag());
    if (!plan) return report_error(plan.error());
    if (Status written = write_slurm_files({directory, options.form, options.slurm_options}, *plan, *wanted); !written)
        return report_error(written.error());
    const bool references = plan->commands.front().name == "references" && !is_done(folders.reference_run);
    auto submission = submit_to_slurm(directory, references, options.shards);
    if (!submission) return report_error(submission.error());
    if (Status written = write_submission(directory, *submission); !written) return report_error(written.error());
    print_line(directory + ": " + std::to_string(wanted->size()) + " of " + counted(options.shards, "shard") +
               " submitted as job " + submission->shards +
               (submission->references.empty() ? "" : " after job " + submission->references + " (references)") +
               ", then job " + submission->merge + " merges them to " + folders.results);
    return exit_holds;
}

std::string task_line(const TaskStatus& task) {
    std::string line = task.name + ": " + state_text(task.state);
    if (task.runs > 0) line += ", " + counted(task.runs, "cell");
    if (task.failed_runs > 0) line += ", " + std::to_string(task.failed_runs) + " FAILED";
    return line + (task.message.empty() ? "" : ": " + task.message);
}

int show_status(const std::string& given) {
    const std::string directory = absolute_path(given);
    auto status = study_status(directory);
    if (!status) return report_error(status.error());
    if (!status->warning.empty()) print_warning(status->warning);
    std::string summary;
    for (const TaskState state : {TaskState::done, TaskState::running, TaskState::queued, TaskState::failed,
                                  TaskState::stopped, TaskState::missing})
        if (const std::size_t count = status->count(state); count > 0)
            summary += (summary.empty() ? "" : ", ") + std::to_string(count) + " " + state_text(state);
    for (const TaskStatus& task : status->tasks) print_line(task_line(task));
    print_line(directory + ": " + counted(status->tasks.size(), "task") + ": " + summary);
    if (status->count(TaskState::failed) > 0) return exit_bad_input;
    return status->count(TaskState::done) == status->tasks.size() ? exit_holds : exit_does_not_hold;
}

}  // namespace

void add_submit_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "submit", "Submits a study to a queue: the references, the cells as an array of tasks, and the merge.");
    auto options = std::make_shared<SubmitOptions>();
    command->add_option("CONFIG.toml", options->config, "the experiment")->required()->option_text("(required)");
    command->add_flag("--slurm", options->slurm, "submits to Slurm, by its sbatch");
    command
        ->add_option("-o,--output", options->directory,
                     "directory for all files of the study; all tasks must be able to access it")
        ->required()
        ->option_text("DIR (required)");
    command->add_option("--shards", options->shards, "number of tasks for the cells")
        ->option_text("N (required)")
        ->check(CLI::Range(1U, 100000U));
    command->add_option("--split-cells", options->split_runs, "renders the samples of each cell in N parts")
        ->option_text("N")
        ->check(CLI::Range(1U, 4096U));
    command->add_option("--cores", options->cores, "cores per task; default 1")
        ->option_text("N")
        ->check(CLI::Range(1U, 4096U));
    command
        ->add_option("--set", options->overrides,
                     "overrides a value of the config, like --set of 'raylex experiment'; may be repeated")
        ->option_text("KEY=VALUE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        ->add_option("--option", options->slurm_options,
                     "option of sbatch for all jobs, such as --option=--partition=long; may be repeated")
        ->option_text("OPTION")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--template", options->form, "your own template of the job files; default: raylex's slurm.sh")
        ->option_text("FILE");
    command->add_flag("--again", options->again,
                      "submits the unfinished work of an earlier submission, and runs failed cells again");
    command->add_flag("--no-calibration", options->no_calibration,
                      "renders nothing for estimates: jobs request no memory, and times are unknown");
    command->add_flag("--no-report", options->no_report, "does not make the report after the merge");
    command->footer(
        "Exit codes: 0 submitted; 2 bad input, or no queue is found: then the job files are written, for use by "
        "hand.");
    command->callback(
        [command, options, &context] { context.exit_code = submit(*command, *options, context.arguments); });
}

void add_status_command(CLI::App& app, CommandContext& context) {
    CLI::App* command =
        app.add_subcommand("status", "Shows the progress of a study on many machines: done, running, failed, missing.");
    auto directory = std::make_shared<std::string>();
    command->add_option("DIR", *directory, "the -o of 'raylex submit', or of 'raylex experiment plan --commands'")
        ->required()
        ->option_text("(required)");
    command->footer(
        "Exit codes: 0 everything is done and merged; 1 not yet; 2 something failed, or the directory has no study.");
    command->callback([directory, &context] { context.exit_code = show_status(*directory); });
}

}  // namespace raylex::experiments
