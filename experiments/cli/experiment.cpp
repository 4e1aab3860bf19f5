// raylex experiment: one subcommand per step from a config to a report.
#include <functional>
#include <memory>
#include <utility>

#include "experiments/cli/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/report/study_report.h"
#include "experiments/study/results.h"
#include "experiments/study/run/merge.h"
#include "experiments/study/run/results_state.h"
#include "experiments/study/run/runner.h"

namespace raylex::experiments {
namespace {

struct ExperimentOptions {
    std::string config, output, shard, cell, report_directory;
    std::vector<std::string> overrides, directories;
    unsigned split_cells = 1;
    bool no_calibration = false, retry = false, report = false;
};

/// Reads the config and does something with it; the exit code.
template <class Work>
int with_config(const ExperimentOptions& options, Work work) {
    install_interrupt_handler();
    auto config = read_experiment_config(options.config, options.overrides);
    if (!config) return report_error(config.error());
    Shard shard;
    if (!options.shard.empty()) {
        auto parsed = parse_shard(options.shard, {"--shard", 0, 0});
        if (!parsed) return report_error(parsed.error());
        shard = *parsed;
    }
    shard.split_cells = options.split_cells;
    return work(std::move(*config), shard);
}

int run_plan(const ExperimentOptions& options) {
    return with_config(options, [&](const ExperimentConfig& config, const Shard& shard) {
        const InterruptsWait wait;
        const Status printed = print_plan(config, options.output, shard, !options.no_calibration, &interrupt_flag());
        if (!printed) return report_error(printed.error());
        return interrupt_flag().load() ? exit_interrupted : exit_holds;
    });
}

int run_cells(const ExperimentOptions& options, bool resume) {
    return with_config(options, [&](const ExperimentConfig& config, const Shard& shard) {
        const InterruptsWait wait;
        auto outcome = run_experiment(config, {options.output, resume, options.retry, shard}, &interrupt_flag());
        if (!outcome) return report_error(outcome.error());
        if (outcome->interrupted) return exit_interrupted;
        if (options.report) {
            auto results = read_experiment(options.output);
            if (!results) return report_error(results.error());
            if (const int code = write_study_report(*results); code != exit_holds) return code;
        }
        if (outcome->failed + outcome->references_failed > 0) return exit_bad_input;
        return outcome->splits_broken > 0 ? exit_does_not_hold : exit_holds;
    });
}

int run_merge(const ExperimentOptions& options) {
    auto outcome = merge_experiments(options.directories, options.output);
    if (!outcome) return report_error(outcome.error());
    print_line(options.output + ": " + std::to_string(outcome->done) + " cells done, " +
               std::to_string(outcome->failed) + " failed, " + std::to_string(outcome->missing) + " not run yet");
    return exit_holds;
}

int run_replay(const ExperimentOptions& options) {
    return with_config(options, [&](ExperimentConfig config, const Shard&) {
        const InterruptsWait wait;
        auto outcome = replay_cell(std::move(config), options.output, options.cell, &interrupt_flag());
        if (!outcome) return report_error(outcome.error());
        if (interrupt_flag().load()) return exit_interrupted;
        std::string compared;
        for (const std::string& each : outcome->compared) compared += (compared.empty() ? "" : ", ") + each;
        print_line(options.cell +
                   (outcome->same ? ": the same bits again, in " + compared : ": DIFFERS in " + outcome->difference));
        return outcome->same ? exit_holds : exit_does_not_hold;
    });
}

/// The config says what the results must be of; it is not read beyond that.
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
    command.add_option("CONFIG.toml", options.config, "the experiment; experiments/README.md lists its keys")
        ->required()
        ->option_text("(required)");
    command
        .add_option(
            "--set", options.overrides,
            "sets a value of the config, as KEY=VALUE: replicates=2, reference.spp=64, method.NAME.max_depth=4, "
            "scene.*.resolution=64x64; tables of a list go by their names; may be repeated")
        ->option_text("KEY=VALUE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_output(CLI::App& command, ExperimentOptions& options, bool required) {
    auto* option = command.add_option("-o,--output", options.output, "directory of the results");
    option->option_text(required ? "DIR (required)" : "DIR");
    if (required) option->required();
}

void add_shard(CLI::App& command, ExperimentOptions& options) {
    command
        .add_option("--shard", options.shard,
                    "only every PARTS-th cell of the plan, beginning with the PART-th; merge makes one of them again")
        ->option_text("PART/PARTS");
    command
        .add_option(
            "--split-cells", options.split_cells,
            "renders the samples of each cell in N parts, which --shard shares out like cells; merge makes the cell of "
            "them, the same bits. Cells that end by time or by error, of external commands, of Markov chains or of few "
            "samples stay whole")
        ->option_text("N")
        ->check(CLI::Range(1U, 4096U));
}

}  // namespace

void add_experiment_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("experiment",
                                           "Runs methods x scenes x settings x budgets x seeds from one config, and "
                                           "keeps every image and its statistics.");
    command->require_subcommand(1);
    auto options = std::make_shared<ExperimentOptions>();
    const auto add = [&](const char* name, const char* description, std::function<int()> work) {
        CLI::App* step = command->add_subcommand(name, description);
        step->callback([work = std::move(work), &context] { context.exit_code = work(); });
        return step;
    };
    CLI::App* plan =
        add("plan", "Prints the cells, the expected time and how it was got, and the memory; writes nothing.",
            [options] { return run_plan(*options); });
    add_config(*plan, *options);
    add_output(*plan, *options, false);
    add_shard(*plan, *options);
    plan->add_flag("--no-calibration", options->no_calibration,
                   "renders nothing: times that only a render can tell are not known");
    CLI::App* run =
        add("run", "Makes the references, then runs the cells.", [options] { return run_cells(*options, false); });
    CLI::App* resume = add("resume", "Goes on with results that are there, at the cell and inside it.",
                           [options] { return run_cells(*options, true); });
    for (CLI::App* each : {run, resume}) {
        add_config(*each, *options);
        add_output(*each, *options, true);
        add_shard(*each, *options);
        each->add_flag("--report", options->report, "and then the report, as 'raylex experiment report' does");
        each->footer(
            "Exit codes: 0 all cells done; 1 a split does not sum; 2 bad input, or cells failed; 130 after Ctrl-C.");
    }
    resume->add_flag("--retry", options->retry, "runs failed cells again");
    CLI::App* merge = add("merge", "Makes one directory of several with cells of one config.",
                          [options] { return run_merge(*options); });
    merge->add_option("DIR", options->directories, "directories of results, in any order")
        ->required()
        ->option_text("...");
    add_output(*merge, *options, true);
    CLI::App* replay =
        add("replay", "Renders a finished cell again and compares every bit; exit code 1 when one differs.",
            [options] { return run_replay(*options); });
    add_config(*replay, *options);
    replay->add_option("CELL", options->cell, "the cell, as cells/ has it")->required()->option_text("(required)");
    add_output(*replay, *options, true);
    CLI::App* report =
        add("report", "Writes report.html, results.csv, results.jsonl and plots/*.svg of the cells that are done.",
            [options] { return run_report(*options); });
    add_config(*report, *options);
    add_output(*report, *options, true);
    report
        ->add_option("--to", options->report_directory, "directory of the report's files; default: that of the results")
        ->option_text("DIR");
}

}  // namespace raylex::experiments
