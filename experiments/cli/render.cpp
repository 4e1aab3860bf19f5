// raylex render: from flags and a job file to a Job; cli/render_run.cpp does the rest.
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "experiments/cli/commands.h"
#include "experiments/program/console.h"
#include "experiments/cli/output_options.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/cli/render_run.h"
#include "experiments/job/channel_set.h"
#include "experiments/job/job_file.h"
#include "experiments/job/sampling_requests.h"
#include "geoaovs/geoaovs.h"

namespace raylex::experiments {
namespace {

struct RenderOptions {
    std::string input, output, statistics, resolution, integrator, sampler, filter, partition, techniques;
    std::string crop, ocio, rendering_space, isa, until_error, time, checkpoint, replay, filter_mode;
    std::optional<std::uint64_t> spp, seed;
    std::optional<int> threads;
    std::optional<std::int64_t> max_depth;
    std::vector<std::string> expressions, channel_files, dialects, aovs, cryptomatte, rules, layers, statistic_layers,
        plugins;
    std::optional<int> cryptomatte_ranks;
    bool no_beauty = false, light_groups = false, resume = false;
    OutputOptions outputs;
};

SourceLocation flag(const std::string& name) {
    return {name, 0, 0};
}

/// The channels of a file, as if each stood behind an --lpe of its own.
Status read_channel_file(const std::string& file, lpe::Dialect dialect, Job& job) {
    auto set = read_channel_files({file}, {}, dialect);
    if (!set) return set.error();
    std::vector<std::string> warnings = std::move(set->file.warnings);
    Status added = add_to_job(*set, job, warnings);
    if (!added) {
        Error error = added.error();
        if (error.file == "--channels") error.file = file;
        return error;
    }
    for (const std::string& warning : warnings) print_warning(warning);
    return added;
}

/// --lpe NAME=EXPR and --channels FILE in the order given, each in the dialect of the last --dialect before it.
Status read_expressions(const CLI::App& command, const RenderOptions& options, Job& job) {
    lpe::Dialect dialect = lpe::Dialect::renderman;
    std::size_t next_expression = 0, next_dialect = 0, next_file = 0;
    for (const CLI::Option* option : command.parse_order()) {
        if (option->get_name() == "--dialect") {
            auto parsed = parse_dialect(options.dialects[next_dialect++], flag("--dialect"));
            if (!parsed) return parsed.error();
            dialect = *parsed;
        } else if (option->get_name() == "--lpe") {
            auto request = parse_named_expression(options.expressions[next_expression++], dialect, "--lpe");
            if (!request) return request.error();
            job.expressions.push_back(std::move(*request));
        } else if (option->get_name() == "--channels") {
            if (Status read = read_channel_file(options.channel_files[next_file++], dialect, job); !read) return read;
        }
    }
    return success();
}

/// --rule NAME=RULE, --layer NAME=CHANNEL:RULE and --statistics NAME=STATISTIC,...
Status read_channel_settings(const RenderOptions& options, transport::RenderSettings& settings) {
    const auto split = [](const std::string& text, const char* option, const char* example) -> Result<std::size_t> {
        const std::size_t equals = text.find('=');
        if (equals != std::string::npos && equals > 0 && equals + 1 < text.size()) return equals;
        return error_at(flag(option), "'" + text + "' says nothing of a channel; expected such as " + example);
    };
    for (const std::string& text : options.rules) {
        auto equals = split(text, "--rule", "Nn=zmin");
        if (!equals) return equals.error();
        auto rule = display::parse_rule_request(text.substr(0, *equals), text.substr(*equals + 1), flag("--rule"));
        if (!rule) return rule.error();
        settings.rules.push_back(std::move(*rule));
    }
    for (const std::string& text : options.layers) {
        auto equals = split(text, "--layer", "nearest=z:zmin");
        if (!equals) return equals.error();
        const std::size_t colon = text.rfind(':');
        if (colon == std::string::npos || colon < *equals)
            return error_at(flag("--layer"),
                            "'" + text + "' names no rule; expected NAME=CHANNEL:RULE, such as nearest=z:zmin");
        auto layer = read_layer_request(text.substr(0, *equals), text.substr(*equals + 1, colon - *equals - 1),
                                        text.substr(colon + 1), flag("--layer"));
        if (!layer) return layer.error();
        settings.layers.push_back(std::move(*layer));
    }
    for (const std::string& text : options.statistic_layers) {
        auto equals = split(text, "--statistics", "beauty=variance,mse");
        if (!equals) return equals.error();
        for (std::size_t begin = *equals + 1; begin <= text.size();) {
            const std::size_t end = std::min(text.find(',', begin), text.size());
            auto layer = display::parse_statistic_request(text.substr(0, *equals), text.substr(begin, end - begin),
                                                          flag("--statistics"));
            if (!layer) return layer.error();
            settings.statistics.push_back(std::move(*layer));
            begin = end + 1;
        }
    }
    return success();
}

Status read_sampling(const RenderOptions& options, Job& job) {
    if (!options.until_error.empty()) {
        auto error = parse_tolerance(options.until_error, flag("--until-error"));
        if (!error) return error.error();
        if (!job.settings.adaptive) job.settings.adaptive.emplace();
        job.settings.adaptive->error = *error;
        job.settings.adaptive->location = flag("--until-error");
    }
    if (options.spp && job.settings.adaptive) apply_sample_limit(*options.spp, *job.settings.adaptive);
    if (!options.time.empty()) {
        auto seconds = parse_interval(options.time, flag("--time"), "time to render for");
        if (!seconds) return seconds.error();
        apply_time_limit(*seconds, job);
    }
    if (!options.checkpoint.empty()) {
        auto seconds = parse_interval(options.checkpoint, flag("--checkpoint"));
        if (!seconds) return seconds.error();
        job.checkpoint_seconds = *seconds;
    }
    job.resume = options.resume;
    if (job.resume && job.checkpoint_seconds == 0) job.checkpoint_seconds = 60;
    return success();
}

void override_entity(const std::string& name, const char* option, std::optional<transport::SceneEntity>& entity) {
    // The same type as in the job keeps the job's parameters.
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

/// --replay X,Y,SAMPLE
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
    return error_at(flag("--replay"), "'" + text + "' is no sample of a pixel; expected X,Y,SAMPLE, such as 12,7,3");
}

/// Flags override the job file.
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
    set(options.isa, job.settings.isa);
    if (job.output.empty()) job.output = std::filesystem::path(options.input).stem().string() + ".exr";
    if (options.spp) job.settings.samples_per_pixel = *options.spp;
    if (options.seed) job.settings.seed = *options.seed;
    if (options.threads) job.settings.threads = *options.threads;
    if (options.max_depth) job.settings.max_depth = *options.max_depth;
    if (options.no_beauty) job.settings.beauty = false;
    if (!options.filter_mode.empty()) job.settings.splat = options.filter_mode == "splat";
    if (!options.resolution.empty()) {
        auto size = parse_resolution(options.resolution, flag("--resolution"));
        if (!size) return size.error();
        job.settings.resolution = *size;
    }
    if (!options.crop.empty()) {
        auto crop = parse_crop(options.crop, flag("--crop"));
        if (!crop) return crop.error();
        job.settings.crop = *crop;
    }
    override_entity(options.integrator, "--integrator", job.settings.integrator);
    override_entity(options.sampler, "--sampler", job.settings.sampler);
    override_entity(options.filter, "--filter", job.settings.filter);
    if (Status outputs = apply_output_options(options.outputs, job); !outputs) return outputs.error();
    if (Status sampling = read_sampling(options, job); !sampling) return sampling.error();
    Status expressions = read_expressions(command, options, job);
    if (!expressions) return expressions.error();
    if (Status settings = read_channel_settings(options, job.settings); !settings) return settings.error();
    for (const std::string& name : options.aovs) job.aovs.push_back({name, flag("--aov " + name)});
    if (!options.cryptomatte.empty()) job.settings.cryptomatte.clear();
    for (const std::string& name : options.cryptomatte)
        if (Status added = add_cryptomatte(name, flag("--cryptomatte"), job.settings); !added) return added.error();
    if (options.cryptomatte_ranks) job.settings.cryptomatte_ranks = *options.cryptomatte_ranks;
    if (!options.partition.empty()) job.shipped_partition = true;
    if (options.light_groups) job.light_groups = true;
    if (!options.techniques.empty()) {
        auto techniques = parse_techniques(options.techniques, flag("--techniques"));
        if (!techniques) return techniques.error();
        job.techniques = *std::move(techniques);
    }
    if (options.replay.empty()) return job;
    auto replay = parse_replay(options.replay);
    if (!replay) return replay.error();
    job.settings.only = *replay;
    return job;
}

/// CLI11 reads "-1" and numbers past 64 bits as some other seed.
std::string refuse_seed(const std::string& text) {
    std::uint64_t seed = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), seed);
    if (failed == std::errc() && end == text.data() + text.size()) return {};
    return "'" + text + "' is no seed; expected a whole number from 0 to 18446744073709551615";
}

std::string refuse_odd(const std::string& text) {
    return !text.empty() && (text.back() - '0') % 2 != 0 ? "'" + text + "' is odd; expected an even number"
                                                         : std::string();
}

/// For --help: every name, so that it is complete.
std::string aov_names() {
    std::string names;
    for (const std::string& name : geoaovs::channel_names()) names += (names.empty() ? "" : ", ") + name;
    return names;
}

void add_options(CLI::App& command, RenderOptions& options) {
    command.add_option("SCENE.pbrt|JOB.toml", options.input, "a pbrt-v4 scene, or a TOML job that names one")
        ->required()
        ->option_text("(required)");
    command
        .add_option("-o,--output", options.output, "image to write; default: the scene's or job's name with .exr, here")
        ->option_text("OUT.exr");
    command.add_option("--spp", options.spp, "samples per pixel; default: as the scene says")
        ->option_text("N")
        ->check(CLI::Range(1, 2147483647));
    command
        .add_option(
            "--until-error", options.until_error,
            "samples each pixel until its standard error is at most E of its value, such as 1%; --spp is then the "
            "most that a pixel may have, default 65536; [adaptive] in a job says more")
        ->option_text("E");
    command
        .add_option("--time", options.time,
                    "renders for so long, such as 30s, 5m or 1h, to within a second; --spp is then the most. The "
                    "samples reached are printed: --spp with their number gives the same bits")
        ->option_text("TIME");
    command
        .add_option(
            "--checkpoint", options.checkpoint,
            "saves the render to OUT.exr.checkpoint every so often, such as 60s, 5m or 1h, and at Ctrl-C; the file is "
            "removed once the image is written")
        ->option_text("TIME");
    command.add_flag(
        "--resume", options.resume,
        "goes on from OUT.exr.checkpoint to the same bits as if nothing had happened, saving every 60s or as "
        "--checkpoint says");
    command.add_option("--seed", options.seed, "seed of the sampler; default 0")
        ->option_text("N")
        ->check(CLI::Validator(refuse_seed, "", "seed"));
    command.add_option("--threads", options.threads, "threads; 0, the default, is all the machine offers")
        ->option_text("N")
        ->check(CLI::Range(0, 4096));
    command.add_option("--resolution", options.resolution, "image size in pixels; default: as the scene says")
        ->option_text("WxH");
    command
        .add_option(
            "--crop", options.crop,
            "renders these pixels alone, to the bits that they have in the whole image: the file's data window in its "
            "display window")
        ->option_text("X0,Y0,X1,Y1");
    command
        .add_option("--integrator", options.integrator,
                    "path, lighttracer, bdpt, pssmlt or a plugin's; default: as the scene says")
        ->option_text("NAME");
    command.add_option("--max-depth", options.max_depth, "at most N scattering events on a path")
        ->option_text("N")
        ->check(CLI::Range(0, 2147483647));
    command.add_option("--sampler", options.sampler, "sampler; default: as the scene says")->option_text("NAME");
    command.add_option("--filter", options.filter, "pixel filter; default: as the scene says")->option_text("NAME");
    command
        .add_option(
            "--filter-mode", options.filter_mode,
            "importance (default): samples are drawn as the pixel filter says and belong to one pixel; splat: they "
            "are drawn evenly and shared by all pixels that the filter reaches, which leaves no statistics, deep "
            "images or cryptomattes")
        ->option_text("MODE")
        ->check(CLI::IsMember({"importance", "splat"}));
    command
        .add_option("--lpe", options.expressions,
                    "adds a layer NAME with the light that the light path expression accepts; may be repeated")
        ->option_text("NAME=EXPR")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option(
            "--channels", options.channel_files,
            "adds the channels of a file as --lpe does, and the partitions that it declares: RIB DisplayChannel lines, "
            "rendermn.ini, USD ASCII RenderVar prims or TOML; may be repeated")
        ->option_text("FILE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option("--dialect", options.dialects,
                    "language of the --lpe and of USD channel files that follow: renderman (default) or osl")
        ->option_text("D")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_option("--partition", options.partition, "'shipped' adds the layers of the shipped partition")
        ->option_text("shipped")
        ->check(CLI::IsMember({"shipped"}));
    command.add_flag("--light-groups", options.light_groups,
                     "adds a layer per light group, and one for lights without a group");
    command
        .add_option(
            "--techniques", options.techniques,
            "'pyramid' adds a layer of beauty for each way to find a path, s vertices from the light and t from "
            "the camera (beauty_s1t3), with its MIS weight and without (beauty_s1t3_unweighted); "
            "'pyramid:CHANNEL,...' of these channels")
        ->option_text("pyramid[:CHANNEL,...]");
    command.add_flag("--no-beauty", options.no_beauty, "renders only what the layers need");
    command
        .add_option("--aov", options.aovs,
                    "adds a geometric AOV by its standard name (" + aov_names() +
                        "), or the channel that a tee texture of the scene writes to; may be repeated")
        ->option_text("NAME")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option(
            "--rule", options.rules,
            "how the samples of a channel become its pixels: filter (the pixel filter), zmin, zmax (the nearest, "
            "farthest sample), min, max, average or sum; may be repeated")
        ->option_text("NAME=RULE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option(
            "--layer", options.layers,
            "adds a layer with the samples of a channel, or of the beauty, made pixels by another rule (as --rule has "
            "them); may be repeated")
        ->option_text("NAME=CHANNEL:RULE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option(
            "--statistics", options.statistic_layers,
            "adds layers NAME_variance (of the samples), NAME_mse (variance of the pixel), NAME_even and NAME_odd "
            "(the image from samples of even, odd index) for the beauty or a filtered channel; may be repeated")
        ->option_text("NAME=STATISTIC,...")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option("--cryptomatte", options.cryptomatte,
                    "adds cryptomattes of these kinds: object, material, asset; not with pixel filters that have "
                    "negative lobes")
        ->option_text("KIND[,KIND...]")
        ->delimiter(',')
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        .add_option("--cryptomatte-ranks", options.cryptomatte_ranks,
                    "how many ids a cryptomatte keeps per pixel, an even number; default 6")
        ->option_text("N")
        ->check(CLI::Range(2, geoaovs::Cryptomatte::most_ranks))
        ->check(CLI::Validator(refuse_odd, "", "even"));
    command
        .add_option("--ocio", options.ocio, "OpenColorIO config; default: $OCIO, else the one that ships with raylex")
        ->option_text("FILE");
    command
        .add_option("--rendering-space", options.rendering_space,
                    "scene-linear space of the config to render in; default: the scene's own")
        ->option_text("NAME");
    command
        .add_option("--isa", options.isa,
                    "instruction set: sse2, sse4.2, avx, avx2 or avx512; default: the best there is")
        ->option_text("NAME");
    command
        .add_option(
            "--replay", options.replay,
            "renders one sample of one pixel alone and prints what every layer gets and what is refused; writes "
            "nothing; exit code 1 when something is refused")
        ->option_text("X,Y,SAMPLE");
    add_output_options(command, options.outputs);
    add_plugin_option(command, options.plugins);
    command.add_option("--stats", options.statistics, "also writes times, ray counts and the like as JSON")
        ->option_text("OUT.json");
}

/// --help in groups, which stand in the order of their first options.
void group_options(CLI::App& command) {
    using Names = std::vector<const char*>;
    const std::pair<const char*, Names> groups[] = {
        {"Files and viewers",
         {"--output", "--exr", "--deep", "--deep-channels", "--deep-samples", "--deep-tolerance", "--deep-tidy",
          "--deep-storage", "--tev", "--driver", "--stats"}},
        {"Sampling",
         {"--spp", "--until-error", "--time", "--seed", "--resolution", "--sampler", "--filter", "--filter-mode",
          "--replay"}},
        {"Long renders", {"--checkpoint", "--resume"}},
        {"Machine", {"--threads", "--isa", "--memory-limit", "--plugin"}},
        {"Light transport", {"--integrator", "--max-depth"}},
        {"Layers",
         {"--lpe", "--channels", "--dialect", "--partition", "--light-groups", "--techniques", "--no-beauty", "--aov",
          "--rule", "--layer", "--statistics", "--cryptomatte", "--cryptomatte-ranks"}},
        {"Colour and previews",
         {"--preview", "--display", "--view", "--exposure", "--ocio", "--rendering-space", "--texture-rules"}},
        {"Filters", {"--sample-filter", "--display-filter"}}};
    for (const auto& [group, names] : groups)
        for (const char* name : names) command.get_option(name)->group(group);
}

}  // namespace

Result<ExpressionRequest> parse_named_expression(const std::string& text, lpe::Dialect dialect,
                                                 const std::string& option) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        return error_at(flag(option),
                        "'" + text + "' is no named expression; expected NAME=EXPR, such as caustics='CDS+L'");
    ExpressionRequest request;
    request.name = text.substr(0, equals);
    request.expression = text.substr(equals + 1);
    request.dialect = dialect;
    request.location = flag(option + " " + request.name);
    return request;
}

void add_render_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("render", "Renders a scene to one multi-part OpenEXR file.");
    auto options = std::make_shared<RenderOptions>();
    add_options(*command, *options);
    command->footer(
        "Layers whose expressions share no path get a 'rest' layer with all other light, and are recorded as the "
        "partition 'auto'\n"
        "that 'raylex verify' checks. Ctrl-C writes what is rendered so far, marked incomplete. The keys of a TOML job "
        "are listed in\n"
        "experiments/README.md; flags override the job.");
    group_options(*command);
    command->callback([command, options, &context] {
        auto job = assemble(*command, *options);
        context.exit_code = job ? run_render(std::move(*job), context.arguments) : report_error(job.error());
    });
}

}  // namespace raylex::experiments
