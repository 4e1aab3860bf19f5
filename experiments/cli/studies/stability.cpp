// raylex stability: runs hard cases and checks each result.
#include <filesystem>
#include <memory>

#include "display/output/atomic_file.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/program/resource.h"
#include "experiments/program/tint.h"
#include "experiments/stability/suite/baseline.h"
#include "experiments/stability/suite/case_file.h"
#include "experiments/stability/suite/line_records.h"
#include "experiments/stability/suite/suite_page.h"
#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

struct StabilityOptions {
    std::vector<std::string> files, plugins;
    std::string output;
    BaselineOptions baseline;
    SuiteOptions suite;
    bool list = false;
};

std::string column(const std::string& text, std::size_t width, bool right = true) {
    const std::string blanks(text.size() < width ? width - text.size() : 0, ' ');
    return (right ? blanks + text : text + blanks) + "  ";
}

void print_lines(const std::vector<LineResult>& lines) {
    std::string rows;
    for (const int row : lines.front().rows) rows += (rows.empty() ? "  row " : ", ") + std::to_string(row);
    print_line(lines.front().name + rows);
    for (const LineResult& line : lines) {
        const bool holds = line.result == LineState::holds, absent = line.result == LineState::not_applicable;
        if (absent) {
            print_line("  not applicable: " + line.note);
            continue;
        }
        print_result("  " + column(line.setting, 34, false) + column(number_text(line.expected, 7), 12) +
                         column(number_text(line.measured, 7), 12) + column(line.error_text(), 12) +
                         column(line.tolerance, 14) + name_of(line.result) +
                         (line.note.empty() ? "" : "  " + line.note),
                     holds);
    }
}

void print_cases(const std::vector<CaseFamily>& families, const SuiteOptions& options) {
    for (const CaseFamily& family : families)
        for (const StabilityCase& each : family.cases)
            if (is_chosen(each, options)) {
                std::string rows;
                for (const int row : each.rows) rows += (rows.empty() ? "" : ",") + std::to_string(row);
                print_line(column(family.name, 12, false) + column(each.name, 36, false) + column(rows, 10, false) +
                           (each.not_applicable.empty() ? each.symptom : "not applicable: " + each.not_applicable));
            }
}

Status write_results(const StabilityOptions& options, const std::vector<CaseFamily>& families,
                     const SuiteResults& results) {
    const fs::path folder = options.output;
    BaselineRun other;
    SuitePage page{&families, &results, nullptr, options.suite.pictures};
    if (!options.baseline.program.empty() && !results.interrupted) {
        BaselineOptions baseline = options.baseline;
        baseline.files = options.files;
        baseline.folder = options.output;
        auto run = run_baseline(baseline, options.suite, &interrupt_flag());
        if (!run) return run.error();
        other = std::move(*run);
        page.baseline = &other;
    }
    for (const auto& [name, text] :
         {std::pair("results.json", results_json(results)), std::pair("results.csv", results_csv(results)),
          std::pair("page.html", suite_page(page))})
        if (Status written = display::write_text_file((folder / name).string(), text); !written) return written;
    return success();
}

int run_stability(StabilityOptions& options) {
    install_interrupt_handler();
    if (Status loaded = load_plugins(options.plugins); !loaded) return report_error(loaded.error());
    if (options.files.empty()) {
        auto suite = resource("stability");
        if (!suite) return report_error(suite.error());
        options.files.push_back(*suite);
    }
    auto families = read_case_files(options.files);
    if (!families) return report_error(families.error());
    if (options.list) {
        print_cases(*families, options.suite);
        return exit_holds;
    }
    if (!options.baseline.program.empty() && options.output.empty())
        return report_error("--beside needs -o FOLDER, because its results appear on the page");
    if (!options.output.empty()) {
        std::error_code failed;
        fs::create_directories(options.output, failed);
        if (failed) return report_error("cannot make the folder '" + options.output + "': " + failed.message());
        options.suite.pictures = options.output;
    }
    const InterruptsWait wait;
    auto results = run_suite(*families, options.suite, &interrupt_flag(), print_lines);
    if (!results) return report_error(results.error());
    if (!options.output.empty())
        if (Status written = write_results(options, *families, *results); !written)
            return report_error(written.error());
    if (results->lines.empty() && !results->interrupted)
        return report_error("the options select no case; 'raylex stability --list' names them");
    const std::size_t good = results->count(LineState::holds), absent = results->count(LineState::not_applicable),
                      bad = results->lines.size() - good - absent;
    print_result(counted(good, "line holds", "lines hold") + ", " + std::to_string(bad) + " not" +
                     (absent > 0 ? ", " + counted(absent, "case", "cases") + " not applicable" : "") + "; " +
                     duration_text(results->seconds),
                 bad == 0);
    if (results->interrupted) return exit_interrupted;
    return bad == 0 ? exit_holds : exit_does_not_hold;
}

}  // namespace

void add_stability_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "stability", "Runs hard numerical cases and compares each measurement with its expected value and tolerance.");
    auto options = std::make_shared<StabilityOptions>();
    command
        ->add_option("SUITE", options->files, "files of cases, or folders with such files; default: raylex's own suite")
        ->option_text("...");
    command
        ->add_option("-o,--output", options->output,
                     "folder for results.json, results.csv, pictures and page.html, which shows everything")
        ->option_text("FOLDER");
    command->add_flag("--fast", options->suite.fast,
                      "leaves out cases marked 'slow', and of other cases the values that are not listed as 'fast'");
    command
        ->add_option("--case", options->suite.names,
                     "runs only cases with this name, which may contain * and ?; may be repeated")
        ->option_text("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        ->add_option("--row", options->suite.rows,
                     "runs only cases for this row of the list of hard cases; may be repeated")
        ->option_text("N")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--threads", options->suite.threads, "number of lines that run at once; default: all cores")
        ->option_text("N")
        ->check(CLI::Range(1, 1024));
    command
        ->add_option("--beside", options->baseline.program,
                     "another raylex program, such as one built with -DRAYLEX_TRANSPORT_DOUBLE=ON; it runs the same "
                     "cases, and the page shows the errors and times of both")
        ->option_text("PROGRAM");
    command
        ->add_option("--scene", options->baseline.scenes,
                     "with --beside: a pbrt file that both programs render with the same random numbers, to compare "
                     "images and times; may be repeated")
        ->option_text("SCENE.pbrt")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--scene-spp", options->baseline.samples, "samples per pixel of these scenes; default 16")
        ->option_text("N");
    command->add_flag("--list", options->list, "lists the cases and ends");
    add_plugin_option(*command, options->plugins);
    command->footer("experiments/docs/stability.md explains how to add a case. Exit code 1: a line does not hold.");
    command->callback([options, &context] { context.exit_code = run_stability(*options); });
}

}  // namespace raylex::experiments
