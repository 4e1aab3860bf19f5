// raylex passes: proposes passes for a scene, from small renders by each method.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "display/output/atomic_file.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/loading_line.h"
#include "experiments/cli/option_group.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/job/job_file.h"
#include "experiments/job/passes/pass_plan.h"
#include "experiments/job/rendering/job_scene.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/propose/proposal.h"
#include "experiments/shards/shard_render.h"
#include "lpe/channels/file_text.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

struct PassesOptions {
    std::string input, output = "-";
    std::vector<std::string> plugins;
    bool propose = false;
    std::optional<std::uint64_t> samples;
    PilotSettings pilot;
};

/// Refuses an output that is an input or that `raylex render` does not read as a job, and jobs that passes do not
/// support.
Status check_proposal(const Job& job, const PassesOptions& options) {
    Job trial = job;
    trial.passes.resize(1);
    trial.passes.front().method.type = "path";
    trial.passes.front().location = {job.job_file, 0, 0};
    if (Status possible = begin_passes(trial); !possible) return possible;
    if (is_standard_output(options.output)) return success();
    if (fs::path(options.output).extension() != ".toml")
        return error_at({options.output, 0, 0}, "a job is written; expected a name that ends in .toml");
    std::error_code failed;
    for (const std::string& input : {options.input, job.scene_file})
        if (fs::equivalent(options.output, input, failed))
            return error_at({options.output, 0, 0}, "is an input and would be overwritten; expected another file");
    return display::check_writable(options.output);
}

/// Returns the beginning of the proposed job: the job of the input, or a [scene] table.
Result<std::string> job_text(const Job& job, const std::string& output) {
    const auto refuse = [&](const char* what, const char* expected) {
        return error_at({job.job_file, 0, 0}, std::string("the job has ") + what, expected);
    };
    if (!job.passes.empty()) return refuse("passes; expected none, because they are proposed", "");
    if (job.settings.paths.integrator) return refuse("an integrator; expected none, because passes are proposed", "");
    std::error_code failed;
    const fs::path folder = is_standard_output(output) ? fs::current_path() : fs::absolute(output).parent_path();
    if (job.job_file.empty())
        return "[scene]\nfile = " + lpe::quoted(fs::relative(job.scene_file, folder, failed).string()) + "\n\n";
    if (!fs::equivalent(folder, fs::absolute(job.job_file).parent_path(), failed))
        return refuse("paths relative to its folder", "expected -o FILE.toml in that folder");
    return job.job_text + (job.job_text.ends_with('\n') ? "\n" : "\n\n");
}

int propose(const PassesOptions& options) {
    install_interrupt_handler();
    if (Status loaded = load_plugins(options.plugins); !loaded) return report_error(loaded.error());
    auto job = read_scene_or_job(options.input);
    if (!job) return report_error(job.error());
    if (Status possible = check_proposal(*job, options); !possible) return report_error(possible.error());
    const auto begin = job_text(*job, options.output);
    if (!begin) return report_error(begin.error());
    if (options.samples) job->settings.samples.per_pixel = options.samples;
    LoadingLine loading;
    auto scene = load_job_scene(*job, loading.progress());
    auto built = scene ? transport::BuiltScene::build((*scene)->scene, job->settings.machine, loading.progress())
                       : scene.error();
    loading.finish();
    if (!built) return report_error(built.error());
    if (const auto ignored = ask_for_film_clamp((*scene)->scene, *job)) print_warning(*ignored);
    auto samples = samples_of_job(*job, (*scene)->scene);
    if (!samples) return report_error(samples.error());
    const auto passes = propose_passes(*job, **scene, **built, *samples, options.pilot);
    if (!passes) return report_error(passes.error());
    if (Status written = write_text(options.output, *begin + *passes); !written) return report_error(written.error());
    if (!is_standard_output(options.output)) write_output(*passes);
    return exit_holds;
}

}  // namespace

void add_passes_command(CLI::App& app, CommandContext& context) {
    CLI::App* command =
        app.add_subcommand("passes", "Proposes a method for each class of paths, from small renders by each method.");
    auto options = std::make_shared<PassesOptions>();
    PilotSettings& pilot = options->pilot;
    command
        ->add_option("SCENE.pbrt|JOB.toml", options->input, "a pbrt-v4 scene, or a job without integrator and passes")
        ->required()
        ->option_text("(required)");
    const OptionGroup group(*command, "Options");
    group
        .add_flag("--propose", options->propose,
                  "renders pilots by path, lighttracer and bdpt, and prints a job with the passes that minimise the "
                  "forecast product of squared error and CPU time")
        ->required();
    group.add("-o,--output", options->output, "FILE.toml", "writes the job to a file; default: standard output");
    group
        .add("--spp", options->samples, "N",
             "samples per pixel of the best single method, whose CPU time the passes take; default: those of the scene "
             "or job")
        ->check(CLI::Range(1, 1 << 30));
    group.add("--pilot-samples", pilot.samples, "N", "samples per pixel and seed of the pilots; default 16")
        ->check(CLI::Range(2, 1 << 20));
    group.add("--seed", pilot.seed, "N", "seed of the first render; default 0");
    add_plugin_option(*command, options->plugins);
    command->footer(
        "Samples of pilots enter no image. Measured CPU times differ from run to run, and so can the proposal; all "
        "else "
        "depends on the seed alone.\n"
        "Exit codes: 0 success, 2 bad usage or input, 130 after Ctrl-C.");
    command->callback([options, &context] { context.exit_code = propose(*options); });
}

}  // namespace raylex::experiments
