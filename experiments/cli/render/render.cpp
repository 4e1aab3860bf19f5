// raylex render: makes a Job from flags and a job file. cli/render/render_run.cpp renders it.
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "experiments/cli/commands.h"
#include "experiments/cli/expression_options.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/cli/render/render_commands.h"
#include "experiments/cli/render/render_options.h"
#include "experiments/cli/render/render_run.h"
#include "experiments/job/job_file.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/program/console.h"
#include "experiments/shards/shard_render.h"
#include "experiments/study/run/runner.h"

namespace raylex::experiments {
namespace {

/// Reads --shard PART/PARTS
Status read_shard(const CLI::App& command, Job& job) {
    const std::string text = command.get_option("--shard")->as<std::string>();
    if (text.empty()) return success();
    auto shard = parse_shard(text, {"--shard", 0, 0});
    if (!shard) return shard.error();
    job.shard = ShardRequest{shard->part, shard->parts, shard_file(job.output, shard->part, shard->parts)};
    std::string& atlas = job.outputs.atlas.file;
    if (!atlas.empty()) atlas = shard_file(atlas, shard->part, shard->parts);
    return success();
}

/// Makes the job from the job file and the flags, which override it.
Result<Job> assemble(const CLI::App& command, const RenderOptions& options) {
    auto base = read_scene_or_job(options.input);
    if (!base) return base;
    if (Status loaded = load_plugins(options.plugins); !loaded) return loaded.error();
    Job job = std::move(*base);
    if (Status applied = apply_flags(command, job); !applied) return applied.error();
    if (job.output.empty()) job.output = std::filesystem::path(options.input).stem().string() + ".exr";
    if (command.count("--spp") > 0 && job.settings.stop.adaptive)
        apply_sample_limit(*job.settings.samples.per_pixel, *job.settings.stop.adaptive);
    if (Status shard = read_shard(command, job); !shard) return shard.error();
    const bool is_saved = job.resume || (job.shard && job.outputs.atlas.file.empty());  // atlases are not saved
    if (is_saved && job.checkpoint_seconds == 0) job.checkpoint_seconds = 60;
    if (Status expressions = read_expressions(command, job); !expressions) return expressions.error();
    return job;
}

}  // namespace

void add_render_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("render", "Renders a scene to one multi-part OpenEXR file.");
    auto options = std::make_shared<RenderOptions>();
    add_render_options(*command, *options);
    command->footer(
        "If the expressions of the layers share no path, a layer 'rest' with all other light is added, and the layers\n"
        "form the partition 'auto', which 'raylex verify' checks. Ctrl-C writes the image rendered so far, marked\n"
        "incomplete. experiments/docs/rendering/settings.md lists all settings; flags override the job.");
    command->callback([command, options, &context] {
        auto job = assemble(*command, *options);
        if (!job) context.exit_code = report_error(job.error());
        else if (!options->commands.format.empty() || job->shard_commands > 0)
            context.exit_code = print_render_commands(*command, *options, std::move(*job), context.arguments);
        else context.exit_code = run_render(std::move(*job), context.arguments);
    });
}

}  // namespace raylex::experiments
