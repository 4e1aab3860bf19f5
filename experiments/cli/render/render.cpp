// raylex render: makes a Job from flags and a job file. cli/render/render_run.cpp renders it.
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/cli/commands.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/cli/render/render_commands.h"
#include "experiments/cli/render/render_options.h"
#include "experiments/cli/render/render_run.h"
#include "experiments/job/job_file.h"
#include "experiments/job/rendering/effect_report.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/program/console.h"
#include "experiments/shards/shard_render.h"
#include "experiments/study/run/runner.h"

namespace raylex::experiments {
namespace {

SourceLocation flag(const std::string& name) {
    return {name, 0, 0};
}

/// Reads --rule NAME=RULE, --layer NAME=CHANNEL:RULE and --statistics NAME=STATISTIC,...
Status read_channel_settings(const RenderOptions& options, transport::ChannelSettings& channels) {
    const auto split = [](const std::string& text, const char* option, const char* example) -> Result<std::size_t> {
        const std::size_t equals = text.find('=');
        if (equals != std::string::npos && equals > 0 && equals + 1 < text.size()) return equals;
        return error_at(flag(option), "'" + text + "' is not a setting of a channel; expected one such as " + example);
    };
    for (const std::string& text : options.rules) {
        auto equals = split(text, "--rule", "Nn=zmin");
        if (!equals) return equals.error();
        auto rule = display::parse_rule_request(text.substr(0, *equals), text.substr(*equals + 1), flag("--rule"));
        if (!rule) return rule.error();
        channels.rules.push_back(std::move(*rule));
    }
    for (const std::string& text : options.layers) {
        auto equals = split(text, "--layer", "nearest=z:zmin");
        if (!equals) return equals.error();
        const std::size_t colon = text.rfind(':');
        if (colon == std::string::npos || colon < *equals)
            return error_at(flag("--layer"),
                            "'" + text + "' has no rule; expected NAME=CHANNEL:RULE, such as nearest=z:zmin");
        auto layer = read_layer_request(text.substr(0, *equals), text.substr(*equals + 1, colon - *equals - 1),
                                        text.substr(colon + 1), flag("--layer"));
        if (!layer) return layer.error();
        channels.layers.push_back(std::move(*layer));
    }
    for (const std::string& text : options.statistic_layers) {
        auto equals = split(text, "--statistics", "beauty=variance,mse");
        if (!equals) return equals.error();
        for (std::size_t begin = *equals + 1; begin <= text.size();) {
            const std::size_t end = std::min(text.find(',', begin), text.size());
            auto layer = display::parse_statistic_request(text.substr(0, *equals), text.substr(begin, end - begin),
                                                          flag("--statistics"));
            if (!layer) return layer.error();
            channels.statistics.push_back(std::move(*layer));
            begin = end + 1;
        }
    }
    return success();
}

Status read_sampling(const RenderOptions& options, Job& job) {
    if (!options.until_error.empty()) {
        auto error = parse_tolerance(options.until_error, flag("--until-error"));
        if (!error) return error.error();
        if (!job.settings.stop.adaptive) job.settings.stop.adaptive.emplace();
        job.settings.stop.adaptive->error = *error;
        job.settings.stop.adaptive->location = flag("--until-error");
    }
    if (options.spp && job.settings.stop.adaptive) apply_sample_limit(*options.spp, *job.settings.stop.adaptive);
    if (!options.time.empty()) {
        auto seconds = parse_interval(options.time, flag("--time"), "render time");
        if (!seconds) return seconds.error();
        apply_time_limit(*seconds, job);
    }
    if (!options.checkpoint.empty()) {
        auto seconds = parse_interval(options.checkpoint, flag("--checkpoint"));
        if (!seconds) return seconds.error();
        job.checkpoint_seconds = *seconds;
    }
    if (!options.memory.empty()) {
        auto memory = display::parse_memory_size(options.memory, flag("--memory"));
        if (!memory) return memory.error();
        bucket_settings(job).memory = *memory;
    }
    if (options.bucket_rows) bucket_settings(job).rows = *options.bucket_rows;
    job.resume = options.resume;
    const bool is_saved = job.resume || (job.shard && job.outputs.atlas.file.empty());  // atlases are not saved
    if (is_saved && job.checkpoint_seconds == 0) job.checkpoint_seconds = 60;
    return success();
}

/// Reads --shard PART/PARTS
Status read_shard(const RenderOptions& options, Job& job) {
    if (options.shard.empty()) return success();
    auto shard = parse_shard(options.shard, flag("--shard"));
    if (!shard) return shard.error();
    job.shard = ShardRequest{shard->part, shard->parts, shard_file(job.output, shard->part, shard->parts)};
    std::string& atlas = job.outputs.atlas.file;
    if (!atlas.empty()) atlas = shard_file(atlas, shard->part, shard->parts);
    return success();
}

void override_entity(const std::string& name, const char* option, std::optional<transport::SceneEntity>& entity) {
    // The parameters in the job stay if the type is the job's.
    if (name.empty() || (entity && entity->type == name)) return;
    transport::SceneEntity chosen;
    chosen.type = name;
    chosen.location = flag(option);
    chosen.parameters.location = flag(option);
    entity = std::move(chosen);
}

Result<Job> base_job(const std::string& input) {
    if (input.empty()) return error_at({}, "the scene's name is empty; expected a pbrt-v4 scene or a TOML job");
    if (std::filesystem::path(input).extension() == ".toml") return read_job(input);
    Job job;
    job.scene_file = input;
    return job;
}

/// Parses --replay X,Y,SAMPLE
Result<transport::SampleChoice> parse_replay(const std::string& text) {
    transport::SampleChoice choice;
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto read = [&](auto& number, bool last) {
        const auto [next, failed] = std::from_chars(at, end, number);
        if (failed != std::errc() || (last ? next != end : next == end || *next != ',')) return false;
        at = next + (last ? 0 : 1);
        return true;
    };
    if (read(choice.x, false) && read(choice.y, false) && read(choice.sample, true)) return choice;
    return error_at(flag("--replay"), "'" + text + "' is not a sample of a pixel; expected X,Y,SAMPLE, such as 12,7,3");
}

Status read_framing(const RenderOptions& options, transport::FilmOverrides& film) {
    if (!options.resolution.empty()) {
        auto size = parse_resolution(options.resolution, flag("--resolution"));
        if (!size) return size.error();
        film.resolution = *size;
    }
    if (!options.crop.empty()) {
        auto crop = parse_crop(options.crop, flag("--crop"));
        if (!crop) return crop.error();
        film.crop = *crop;
    }
    return success();
}

/// Makes the job from the job file and the flags, which override it.
Result<Job> assemble(const CLI::App& command, const RenderOptions& options) {
    auto base = base_job(options.input);
    if (!base) return base;
    if (Status loaded = load_plugins(options.plugins); !loaded) return loaded.error();
    Job job = std::move(*base);
    const auto set = [](const std::string& from, std::string& to) {
        if (!from.empty()) to = from;
    };
    set(options.output, job.output);
    set(options.statistics, job.statistics);
    set(options.ocio, job.ocio_config);
    set(options.rendering_space, job.rendering_space);
    set(options.isa, job.settings.machine.isa);
    if (job.output.empty()) job.output = std::filesystem::path(options.input).stem().string() + ".exr";
    if (options.spp) job.settings.samples.per_pixel = *options.spp;
    if (options.seed) job.settings.samples.seed = *options.seed;
    if (options.threads) job.settings.machine.threads = *options.threads;
    if (options.max_depth) job.settings.paths.max_depth = *options.max_depth;
    if (options.no_beauty) job.settings.channels.beauty = false;
    if (!options.prune.empty()) job.settings.paths.prune = options.prune == "on";
    for (const std::string& text : options.effects)
        if (Status added = add_effect_choice(text, flag("--effect"), job.effects); !added) return added.error();
    job.show_effects = options.show_effects;
    if (!options.filter_mode.empty()) job.settings.film.splat = options.filter_mode == "splat";
    if (Status framed = read_framing(options, job.settings.film); !framed) return framed.error();
    if (!options.missing.empty()) {
        auto missing = parse_missing(options.missing, flag("--missing"));
        if (!missing) return missing.error();
        job.missing = *missing;
    }
    override_entity(options.integrator, "--integrator", job.settings.paths.integrator);
    override_entity(options.sampler, "--sampler", job.settings.samples.sampler);
    override_entity(options.filter, "--filter", job.settings.film.filter);
    if (Status outputs = apply_output_options(options.outputs, job); !outputs) return outputs.error();
    if (Status shard = read_shard(options, job); !shard) return shard.error();
    if (Status sampling = read_sampling(options, job); !sampling) return sampling.error();
    if (Status expressions = read_expressions(command, options, job); !expressions) return expressions.error();
    if (Status settings = read_channel_settings(options, job.settings.channels); !settings) return settings.error();
    for (const std::string& text : options.declared) {
        auto channel = display::parse_declared_channel(text, flag("--channel " + text));
        if (!channel) return channel.error();
        channel->origin = "--channel " + text;
        job.declared.push_back(*std::move(channel));
    }
    for (const std::string& name : options.aovs) job.aovs.push_back({name, flag("--aov " + name)});
    if (!options.cryptomatte.empty()) job.settings.mattes.kinds.clear();
    for (const std::string& name : options.cryptomatte)
        if (Status added = add_cryptomatte(name, flag("--cryptomatte"), job.settings.mattes); !added)
            return added.error();
    if (options.cryptomatte_ranks) job.settings.mattes.ranks = *options.cryptomatte_ranks;
    if (!options.techniques.empty()) {
        auto techniques = parse_techniques(options.techniques, flag("--techniques"));
        if (!techniques) return techniques.error();
        job.techniques = *std::move(techniques);
    }
    if (options.replay.empty()) return job;
    auto replay = parse_replay(options.replay);
    if (!replay) return replay.error();
    job.settings.samples.only = *replay;
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
        "incomplete. experiments/docs/rendering/jobs.md lists the keys of a job; flags override the job.");
    command->callback([command, options, &context] {
        auto job = assemble(*command, *options);
        if (!job) context.exit_code = report_error(job.error());
        else if (!options->commands.format.empty() || options->shards > 0)
            context.exit_code = print_render_commands(*command, *options, std::move(*job), context.arguments);
        else context.exit_code = run_render(std::move(*job), context.arguments);
    });
}

}  // namespace raylex::experiments
