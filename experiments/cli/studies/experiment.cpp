// raylex experiment: one subcommand for each step from a config to a report.
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "experiments/cli/command_output.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/studies/experiment_merge.h"
#include "experiments/cluster/study_commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/report/study_report.h"
#include "experiments/study/results.h"
#include "experiments/study/run/results_state.h"
#include "experiments/study/run/run_marks.h"
#include "experiments/study/run/runner.h"

namespace raylex::experiments {
namespace {

struct ExperimentOptions {
    std::string config, output, shard, run, report_directory, references;
    std::vector<std::string> overrides;
    unsigned split_runs = 1, shards = 0, threads = 0;
    bool retry = false, report = false, resume = false, only_references = false;
    CommandOutputOptions commands;
};

/// Reads the config, calls `work` with it and returns the exit code.
template <class Work>
int with_config(const ExperimentOptions& options, Work work) {
    install_interrupt_handler();
    auto config = read_experiment_config(options.config, options.overrides);
    if (!config) return report_error(config.error());
    // The folder of references and the number of threads change neither the rendered bits nor the hash of the config.
    if (!options.references.empty()) config->reference.cache = absolute_path(options.references);
    if (options.threads > 0) config->base.settings.machine.threads = static_cast<int>(options.threads);
    Shard shard;
    if (!options.shard.empty()) {
        auto parsed = parse_shard(options.shard, {"--shard", 0, 0});
        if (!parsed) return report_error(parsed.error());
        shard = *parsed;
    }
    shard.split_runs = options.split_runs;
    return work(std::move(*config), shard);
}

/// Runs raylex experiment plan --commands and returns the exit code.
int print_study_commands(const CLI::App& command, const ExperimentOptions& options,
                         const std::vector<std::string>& arguments) {
    return with_config(options, [&](const ExperimentConfig& config, const Shard& shard) {
        if (options.output.empty())
            return report_error("--commands without a directory for the results; expected -o DIR as well");
        if (shard.parts > 1) return report_error("--shard and --commands exclude each other; expected --shards N");
        std::vector<std::string> words = standing_alone(
            command, arguments,
            {"--commands", "--no-calibration", "--shards", "--split-cells", "--threads", "-o", "--output", "--shard"});
        words.erase(words.begin(), words.begin() + 3);  // the program, "experiment" and "plan"
        const StudyCommandsRequest request{.directory = absolute_path(options.output),
                                           .shards = std::max(1U, options.shards),
                                           .split_runs = options.split_runs,
                                           .threads = options.threads,
                                           .config = words,
                                           .calibrate = !options.commands.no_calibration};
        const InterruptsWait wait;
        auto plan = study_commands(config, request, &interrupt_flag());
        if (interrupt_flag().load()) return exit_interrupted;
        if (!plan) return report_error(plan.error());
        return print_commands(*plan, options.commands.format);
    });
}

int run_plan(const CLI::App& command, const ExperimentOptions& options, const std::vector<std::string>& arguments) {
    if (!options.commands.format.empty()) return print_study_commands(command, options, arguments);
    if (options.shards > 0)
        return report_error(
            "--shards without --commands; expected --commands as well, to print the commands of that many shards");
    return with_config(options, [&](const ExperimentConfig& config, const Shard& shard) {
        const InterruptsWait wait;
        const Status printed =
            print_plan(config, options.output, shard, !options.commands.no_calibration, &interrupt_flag());
        if (!printed) return report_error(printed.error());
        return interrupt_flag().load() ? exit_interrupted : exit_holds;
    });
}

/// Returns an error if the directory contains a run with other settings.
Status check_same_run(const std::string& directory, const RunMark& mark) {
    const auto there = begun_mark(directory);
    if (!there || (there->config_hash == mark.config_hash && there->shard.part == mark.shard.part &&
                   there->shard.parts == mark.shard.parts && there->shard.split_runs == mark.shard.split_runs))
        return success();
    return error_at({directory, 0, 0},
                    "this directory contains a run of another config, --set, --shard or --split-cells",
                    "choose another directory with -o, or the settings of that run");
}

/// Returns the exit code of an earlier run in this directory that finished the whole study; nothing if there is none.
std::optional<int> done_before(const ExperimentOptions& options, const RunMark& mark) {
    const auto there = finished_mark(options.output);
    if (!there || options.retry || there->config_hash != mark.config_hash || there->shard.part != mark.shard.part ||
        there->shard.parts != mark.shard.parts || there->shard.split_runs != mark.shard.split_runs ||
        there->only_references != mark.only_references)
        return std::nullopt;
    print_line(options.output + ": already done, " + counted(there->done, "cell") +
               (there->failed > 0 ? ", " + std::to_string(there->failed) + " FAILED" : ""));
    return there->failed > 0 ? exit_bad_input : exit_holds;
}

int run_all(const ExperimentOptions& options, bool resume) {
    return with_config(options, [&](const ExperimentConfig& config, const Shard& shard) {
        const bool begin = options.resume || options.only_references;
        if (options.retry && !begin && !resume)
            return report_error("--retry without --resume; expected both, to run failed cells again");
        RunMark mark{config.hash, shard, options.only_references};
        if (begin) {
            if (const auto code = done_before(options, mark)) return *code;
            if (Status same = check_same_run(options.output, mark); !same) return report_error(same.error());
            if (Status begun = mark_begun(options.output, mark); !begun) return report_error(begun.error());
        }
        const InterruptsWait wait;
        const RunRequest request{.directory = options.output,
                                 .resume = resume || begin,
                                 .retry = options.retry,
                                 .begin = begin,
                                 .only_references = options.only_references,
                                 .shard = shard};
        auto outcome = run_experiment(config, request, &interrupt_flag());
        if (!outcome && begin) mark_error(options.output, outcome.error());
        if (!outcome) return report_error(outcome.error());
        if (outcome->interrupted) return exit_interrupted;
        if (begin) {
            mark.done = outcome->done + outcome->parts;
            mark.failed = outcome->failed + outcome->references_failed;
            if (Status done = mark_finished(options.output, mark); !done) return report_error(done.error());
        }
        if (options.report) {
            auto results = read_experiment(options.output);
            if (!results) return report_error(results.error());
            if (const int code = write_study_report(*results); code != exit_holds) return code;
        }
        if (outcome->failed + outcome->references_failed > 0) return exit_bad_input;
        return outcome->splits_broken > 0 ? exit_does_not_hold : exit_holds;
    });
}

int run_replay(const ExperimentOptions& options) {
    return with_config(options, [&](ExperimentConfig config, const Shard&) {
        const InterruptsWait wait;
        auto outcome = replay_run(std::move(config), options.output, options.run, &interrupt_flag());
        if (!outcome) return report_error(outcome.error());
        if (interrupt_flag().load()) return exit_interrupted;
        std::string compared;
        for (const std::string& each : outcome->compared) compared += (compared.empty() ? "" : ", ") + each;
        print_line(options.run +
                   (outcome->same ? ": the same bits, in " + compared : ": DIFFERS in " + outcome->difference));
        return outcome->same ? exit_holds : exit_does_not_hold;
    });
}

/// Writes the report. The config is only compared with the results.
int run_report(const ExperimentOptions& options) {
    return with_config(options, [&](const ExperimentConfig& config, const Shard&) {
        auto results = read_experiment(options.output);
        if (!results) return report_error(results.error());
        if (Status same = check_same_config(*results, config); !same) return report_error(same.error());
        StudyReportOptions report;
        report.directory = options.report_directory;
        return write_study_report(*results, report);
    });
}

void add_config(CLI::App& command, ExperimentOptions& options) {
    command
        .add_option("CONFIG.toml", options.config, "the experiment; experiments/docs/studies/config.md lists its keys")
        ->required()
        ->option_text("(required)");
    command
        .add_option(
            "--set", options.overrides,
            "overrides a value of the config, as KEY=VALUE: replicates=2, reference.spp=64, method.NAME.max_depth=4, "
            "scene.*.resolution=64x64; NAME selects a table of a list; may be repeated")
        ->option_text("KEY=VALUE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_output(CLI::App& command, ExperimentOptions& options, bool required) {
    auto* option = command.add_option("-o,--output", options.output, "directory for the results");
    option->option_text(required ? "DIR (required)" : "DIR");
    if (required) option->required();
}

void add_threads(CLI::App& command, ExperimentOptions& options) {
    command
        .add_option("--threads", options.threads, "number of threads, instead of the config's; the bits stay the same")
        ->option_text("N")
        ->check(CLI::Range(1U, 4096U));
}

void add_merge_options(CLI::App& command, ExperimentMergeOptions& options) {
    command.add_option("DIR", options.directories, "directories of results, in any order")
        ->required()
        ->option_text("...");
    command.add_option("-o,--output", options.output, "directory for the merged results")
        ->required()
        ->option_text("DIR (required)");
    command
        .add_option("--shards", options.shards,
                    "merges DIR/1 to DIR/N, the results of 'run --resume --shard', all of which must be finished")
        ->option_text("N")
        ->check(CLI::Range(1U, 100000U));
    command.add_flag(
        "--wait", options.wait,
        "waits for shards that processes on this machine are running, and ten seconds for a process to begin");
    command.add_flag("--replace", options.replace, "replaces the results of an earlier merge in the same directory");
    command.add_flag("--report", options.report, "then writes the report, like 'raylex experiment report'");
}

void add_shard(CLI::App& command, ExperimentOptions& options) {
    command
        .add_option("--shard", options.shard,
                    "runs only every PARTS-th cell of the plan, beginning with the PART-th; 'experiment merge' "
                    "combines the parts")
        ->option_text("PART/PARTS");
    command
        .add_option("--split-cells", options.split_runs,
                    "renders the samples of each cell in N parts, which --shard distributes like cells; 'experiment "
                    "merge' combines them with the same bits. Cells that end by time or error, run external commands, "
                    "use Markov chains or have few samples stay whole")
        ->option_text("N")
        ->check(CLI::Range(1U, 4096U));
}

void add_plan_options(CLI::App& command, ExperimentOptions& options) {
    add_config(command, options);
    add_output(command, options, false);
    add_shard(command, options);
    command.add_option("--shards", options.shards, "with --commands: number of shards of the cells; default 1")
        ->option_text("N")
        ->check(CLI::Range(1U, 100000U));
    add_threads(command, options);
    command.add_flag("--no-calibration", options.commands.no_calibration,
                     "renders nothing; times that need a test render are unknown");
    add_command_output_options(command, options.commands, "");
}

void add_run_options(CLI::App& command, ExperimentOptions& options) {
    add_config(command, options);
    add_output(command, options, true);
    add_shard(command, options);
    command.add_flag("--report", options.report, "then writes the report, like 'raylex experiment report'");
    add_threads(command, options);
    command
        .add_option("--references", options.references,
                    "folder of references that several runs share; one run renders a reference while the others wait; "
                    "default: the config's folder, else in the results")
        ->option_text("DIR");
    command.add_flag("--retry", options.retry, "runs failed cells again");
    command.footer(
        "Exit codes: 0 all cells done; 1 a split does not sum; 2 bad input, or cells failed; 130 after Ctrl-C.");
}

}  // namespace

void add_experiment_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "experiment",
        "Runs methods x scenes x settings x budgets x seeds from one config, and stores all images and statistics.");
    command->require_subcommand(1);
    auto options = std::make_shared<ExperimentOptions>();
    const auto add = [&](const char* name, const char* description, std::function<int()> work) {
        CLI::App* step = command->add_subcommand(name, description);
        step->callback([work = std::move(work), &context] { context.exit_code = work(); });
        return step;
    };
    CLI::App* plan =
        add("plan", "Prints the cells, the expected time with its source, and the memory; writes no file.", {});
    plan->callback([plan, options, &context] { context.exit_code = run_plan(*plan, *options, context.arguments); });
    add_plan_options(*plan, *options);
    CLI::App* run =
        add("run", "Renders the references, then runs the cells.", [options] { return run_all(*options, false); });
    CLI::App* resume = add("resume", "Continues an interrupted run, even inside a cell.",
                           [options] { return run_all(*options, true); });
    for (CLI::App* each : {run, resume}) add_run_options(*each, *options);
    run->add_flag("--resume", options->resume, "begins or continues; does nothing if the run is finished");
    run->add_flag("--only-references", options->only_references, "renders only the references; begins or continues");
    auto merging = std::make_shared<ExperimentMergeOptions>();
    CLI::App* merge = add("merge", "Merges several directories with cells of one config.",
                          [merging] { return merge_study(*merging); });
    add_merge_options(*merge, *merging);
    CLI::App* replay =
        add("replay", "Renders a finished cell again and compares every bit; exit code 1 when one differs.",
            [options] { return run_replay(*options); });
    add_config(*replay, *options);
    replay->add_option("CELL", options->run, "name of the cell in cells/")->required()->option_text("(required)");
    add_output(*replay, *options, true);
    CLI::App* report =
        add("report", "Writes report.html, results.csv, results.jsonl and plots/*.svg for the finished cells.",
            [options] { return run_report(*options); });
    add_config(*report, *options);
    add_output(*report, *options, true);
    report
        ->add_option("--to", options->report_directory,
                     "directory for the report; default: the directory of the results")
        ->option_text("DIR");
}

}  // namespace raylex::experiments
