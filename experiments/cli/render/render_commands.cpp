#include "experiments/cli/render/render_commands.h"

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "experiments/cli/render/render_run.h"
#include "experiments/program/console.h"
#include "experiments/shards/shard_render.h"

namespace raylex::experiments {
namespace {

/// Returns the command line of all shards, without the number of the shard.
std::vector<std::string> shard_arguments(const CLI::App& command, const Job& job,
                                         const std::vector<std::string>& arguments, const std::string& output) {
    std::vector<std::string> all =
        standing_alone(command, arguments,
                       {"--commands", "--no-calibration", "--shards", "-o", "--output", "--guide-only", "--preview",
                        "--driver", "--tev", "--stats", "--resume"});
    // Adds the colour config of this environment, because the environment of other machines can differ.
    if (const char* config = std::getenv("OCIO"); config != nullptr && *config != '\0' && job.ocio_config.empty())
        all.insert(all.end(), {"--ocio", std::filesystem::exists(config) ? absolute_path(config) : config});
    all.insert(all.end(), {"-o", output});
    return all;
}

std::string left_out_note(const Job& job) {
    if (job.preview.empty() && job.statistics.empty() && job.outputs.drivers.empty()) return {};
    return "previews, viewers and statistics are left out; 'raylex preview' and 'raylex report' show the merged image";
}

}  // namespace

int print_render_commands(const CLI::App& command, const RenderOptions& options, Job job,
                          const std::vector<std::string>& arguments) {
    if (options.commands.format.empty())
        return report_error(
            "--shards without --commands; expected --commands as well, to print the commands of that many shards, or "
            "--shard 1/" +
            std::to_string(job.shard_commands) + ", to render one of them");
    if (job.shard_commands == 0)
        return report_error("--commands without a number of shards; expected --shards N as well");
    if (job.shard)
        return report_error("--shard and --commands exclude each other; --commands prints the commands of all shards");
    const unsigned shards = job.shard_commands;
    const std::string output = absolute_path(job.output), note = left_out_note(job);
    const std::vector<std::string> base = shard_arguments(command, job, arguments, output);
    const int threads = job.settings.machine.threads;
    const std::string atlas = job.outputs.atlas.file.empty() ? "" : absolute_path(job.outputs.atlas.file);
    const std::string guide_file = job.settings.paths.guide_file;
    RenderEstimate estimate;
    if (auto code = estimate_render(std::move(job), arguments, !options.commands.no_calibration, estimate))
        return *code;
    CommandPlan plan;
    plan.name = job_name(std::filesystem::path(output).stem().string());
    plan.notes.push_back(
        "Each command can run by itself. Repeated commands skip finished work and resume interrupted work.");
    plan.notes.push_back("The last command merges the records of the others into " + output);
    if (!note.empty()) plan.notes.push_back(note);
    PlannedCommand merge;
    merge.name = "merge";
    merge.arguments = {base.front(), "merge", "--shards", std::to_string(shards), "--wait", "-o", output};
    if (!atlas.empty()) merge.arguments.insert(merge.arguments.end(), {"--atlas", atlas});
    merge.target = output;
    merge.memory_bytes = estimate.memory_bytes;
    const unsigned cores = threads > 0 ? static_cast<unsigned>(threads) : std::thread::hardware_concurrency();
    if (!guide_file.empty()) {
        PlannedCommand guide;
        guide.name = "guide";
        guide.arguments = base;
        guide.arguments.emplace_back("--guide-only");
        guide.target = absolute_path(guide_file);
        guide.memory_bytes = estimate.memory_bytes;
        guide.cores = cores;
        plan.commands.push_back(std::move(guide));
    }
    for (unsigned part = 1; part <= shards; ++part) {
        auto range = shard_range(part, shards, estimate.samples_per_pixel);
        if (!range) return report_error(range.error());
        PlannedCommand shard;
        shard.name = "shard-" + std::to_string(part) + "-of-" + std::to_string(shards);
        shard.arguments = base;
        shard.arguments.insert(shard.arguments.end(), {"--shard", std::to_string(part) + "/" + std::to_string(shards)});
        shard.target = shard_file(output, part, shards);
        shard.memory_bytes = estimate.memory_bytes;
        if (estimate.cpu_seconds >= 0)
            shard.cpu_seconds = estimate.cpu_seconds * static_cast<double>(range->end - range->first) /
                                static_cast<double>(range->total);
        shard.cores = cores;
        if (!guide_file.empty()) shard.needs = {"guide"};
        merge.needs.push_back(shard.name);
        plan.commands.push_back(std::move(shard));
    }
    plan.commands.push_back(std::move(merge));
    return print_commands(plan, options.commands.format);
}

}  // namespace raylex::experiments
