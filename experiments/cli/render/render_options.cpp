#include "experiments/cli/render/render_options.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "display/services/processor.h"
#include "experiments/cli/option_group.h"
#include "experiments/cli/plugin_options.h"
#include "geoaovs/geoaovs.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {
namespace {

/// The options in --help: the ones that people use most. --help-all shows every option.
constexpr std::array often_used{"help",        "help-all",     "output",     "preview",    "stats",     "atlas",
                                "spp",         "seed",         "resolution", "crop",       "time",      "checkpoint",
                                "until-error", "resume",       "threads",    "integrator", "max-depth", "lpe",
                                "channels",    "light-groups", "aov",        "cryptomatte"};

class ShortHelp final : public CLI::Formatter {
  public:
    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
        if (mode == CLI::AppFormatMode::All) return Formatter().make_help(app, name, mode);
        return Formatter::make_help(app, name, mode) + "'raylex render --help-all' lists all options.\n";
    }
    std::string make_group(std::string group, bool positional, std::vector<const CLI::Option*> options) const override {
        const auto is_rare = [](const CLI::Option* option) {
            return std::none_of(often_used.begin(), often_used.end(),
                                [&](const char* name) { return option->check_lname(name); });
        };
        if (!positional) std::erase_if(options, is_rare);
        return options.empty() ? std::string() : Formatter::make_group(group, positional, options);
    }
};

/// Refuses values that are not seeds. CLI11 would turn "-1" and numbers beyond 64 bits into other seeds.
std::string refuse_seed(const std::string& text) {
    std::uint64_t seed = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), seed);
    if (failed == std::errc() && end == text.data() + text.size()) return {};
    return "'" + text + "' is not a seed; expected a whole number from 0 to 18446744073709551615";
}

std::string refuse_odd(const std::string& text) {
    return !text.empty() && (text.back() - '0') % 2 != 0 ? "'" + text + "' is odd; expected an even number"
                                                         : std::string();
}

/// Returns the names of all geometric AOVs, for --help.
std::string aov_names() {
    std::string names;
    for (const std::string& name : geoaovs::channel_names()) names += (names.empty() ? "" : ", ") + name;
    return names;
}

std::string effect_names() {
    std::string names;
    for (const transport::EffectInfo& each : transport::effect_catalogue())
        names += (names.empty() ? "" : ", ") + std::string(each.name);
    return names;
}

void add_sampling_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--spp", options.spp, "N", "samples per pixel; default: the scene's value")
        ->check(CLI::Range(1, 2147483647));
    group.add("--until-error", options.until_error, "E",
              "samples each pixel until the standard error of the beauty (without beauty: of every layer of light) is "
              "at most E of its value, such as 1%; --spp is then the maximum, default 65536. The table [adaptive] of a "
              "job has more settings");
    group.add("--time", options.time, "TIME",
              "stops the render after this time (to within a second), such as 30s, 5m or 1h; --spp is then the "
              "maximum. The number of samples is printed; --spp with that number gives the same bits");
    group.add("--seed", options.seed, "N", "seed of the sampler; default 0")
        ->check(CLI::Validator(refuse_seed, "", "seed"));
    group.add("--sampler", options.sampler, "NAME", "sampler; default: the scene's");
    group.add("--replay", options.replay, "X,Y,SAMPLE",
              "renders one sample of one pixel and prints its value in every layer and all rejected values (NaN or "
              "infinite); writes no file; exit code 1 if a value is rejected");
}

void add_image_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--resolution", options.resolution, "WxH", "image size in pixels; default: the scene's size");
    group.add("--crop", options.crop, "X0,Y0,X1,Y1",
              "renders only this rectangle; its pixels have the same bits as in the whole image. In the file, it is "
              "the data window inside the display window of the whole image");
    group.add("--filter", options.filter, "NAME", "pixel filter; default: the scene's");
    group.add("--missing", options.missing, "error|placeholder",
              "what happens if the file of a texture, light image or mesh is missing: error (default); or placeholder: "
              "renders magenta in its place, and counts the files in warnings and in the image's header");
    group
        .add(
            "--filter-mode", options.filter_mode, "MODE",
            "importance (default): draws samples in proportion to the pixel filter, each for one pixel; splat: draws "
            "samples uniformly, each for all pixels under the filter, without statistics, deep images and cryptomattes")
        ->check(CLI::IsMember({"importance", "splat"}));
}

void add_schedule_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--checkpoint", options.checkpoint, "TIME",
              "saves the render to OUT.exr.checkpoint at this interval, such as 60s, 5m or 1h, and at Ctrl-C; the file "
              "is removed when the image is written");
    group.add_flag("--resume", options.resume,
                   "continues from OUT.exr.checkpoint; the image has the same bits as without the interruption. Saves "
                   "every 60s, or at the interval of --checkpoint");
    group.add("--shard", options.shard, "PART/PARTS",
              "renders one part of the samples, such as 2/4, to OUT.exr.shard-2-of-4. Does nothing if that file "
              "exists; continues from a checkpoint after an interruption. 'raylex merge' combines all shards into the "
              "image, with the same bits as a single render");
    group
        .add("--shards", options.shards, "N",
             "with --commands: prints the commands of this many shards and the command that merges them, with the "
             "memory, CPU seconds and cores of each")
        ->check(CLI::Range(1U, 100000U));
}

void add_machine_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--threads", options.threads, "N", "number of threads; default 0: all cores")->check(CLI::Range(0, 4096));
    group.add("--isa", options.isa, "NAME",
              "instruction set: " + std::string(display::instruction_set_names) +
                  "; default: the best that the processor supports");
    group.add("--memory-limit", options.outputs.memory_limit, "SIZE",
              "refuses a render whose layers need more memory, such as 8G; default: no limit");
    group.add("--memory", options.memory, "SIZE",
              "memory limit of the whole program, such as 2GiB; default: no limit. A larger image is rendered in "
              "buckets (bands of rows) with the same bits. Each finished bucket is saved in the folder "
              "OUT.exr.checkpoint; --resume renders the missing ones");
    group
        .add("--bucket-rows", options.bucket_rows, "N",
             "renders in buckets of N rows, even if the whole image fits into memory")
        ->check(CLI::Range(1, 65536));
}

void add_method_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--integrator", options.integrator, "NAME",
              "path, lighttracer, bdpt, pssmlt or one of a plugin; default: the scene's");
    group.add("--max-depth", options.max_depth, "N", "maximum number of scattering events on a path")
        ->check(CLI::Range(0, 2147483647));
    group.add_repeated("--effect", options.effects, "NAME=on|off",
                       "turns an effect off that the scene needs (to measure its cost and its contribution), or on "
                       "where the scene does not need it (to measure the saving): " +
                           effect_names());
    group.add_flag("--effects", options.show_effects, "prints for every effect whether it is simulated, and why");
}

void add_light_layer_options(const OptionGroup& group, RenderOptions& options) {
    add_expression_options(group, options);
    group.add("--techniques", options.techniques, "pyramid[:CHANNEL,...]",
              "'pyramid' splits the beauty by sampling technique: a technique takes s vertices from the light and t "
              "from the camera. Each adds two layers, with its MIS weight (beauty_s1t3) and without "
              "(beauty_s1t3_unweighted). 'pyramid:CHANNEL,...' splits these channels instead");
    group.add_flag("--no-beauty", options.no_beauty, "renders only the light that the layers need");
    group
        .add("--prune", options.prune, "WHEN",
             "on (default): without beauty, light paths that no layer accepts are not simulated; off: they are "
             "simulated, to measure the saving")
        ->check(CLI::IsMember({"on", "off"}));
}

void add_sample_layer_options(const OptionGroup& group, RenderOptions& options) {
    group
        .add_repeated("--aov", options.aovs, "NAME[,NAME...]",
                      "adds geometric AOVs by name (" + aov_names() +
                          "), channels that textures of the scene write, or channels that plugins declare")
        ->delimiter(',');
    group.add_repeated("--channel", options.declared, "NAME:TYPE",
                       "adds a layer that plugins, patterns and materials can write by name; TYPE is float, rgb, "
                       "point, normal, vector or integer");
    group.add_repeated("--rule", options.rules, "NAME=RULE",
                       "how samples of a channel are combined into pixels: filter (the pixel filter), zmin (nearest "
                       "sample), zmax (farthest sample), min, max, average or sum");
    group.add_repeated(
        "--layer", options.layers, "NAME=CHANNEL:RULE",
        "adds a layer with the samples of a channel, or of the beauty, combined by another rule of --rule");
    group.add_repeated(
        "--statistics", options.statistic_layers, "NAME=STATISTIC,...",
        "adds layers with statistics of the beauty or a filtered channel: NAME_variance (variance of the samples), "
        "NAME_mse (variance of the pixel), NAME_even and NAME_odd (images from samples of even and odd index)");
    group
        .add_repeated("--cryptomatte", options.cryptomatte, "KIND[,KIND...]",
                      "adds cryptomattes of these kinds: object, material, asset; pixel filters with negative lobes "
                      "are not allowed")
        ->delimiter(',');
    group
        .add("--cryptomatte-ranks", options.cryptomatte_ranks, "N",
             "number of ids per pixel in a cryptomatte, an even number; default 6")
        ->check(CLI::Range(2, geoaovs::Cryptomatte::most_ranks))
        ->check(CLI::Validator(refuse_odd, "", "even"));
}

void add_color_space_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--ocio", options.ocio, "FILE", "OpenColorIO config; default: $OCIO, else raylex's own");
    group.add("--rendering-space", options.rendering_space, "NAME",
              "scene-linear space of the config in which to render; default: the scene's");
}

}  // namespace

void add_render_options(CLI::App& command, RenderOptions& options) {
    command.formatter(std::make_shared<ShortHelp>());
    command.set_help_all_flag("--help-all", "Print all options and exit");
    command.add_option("SCENE.pbrt|JOB.toml", options.input, "a pbrt-v4 scene, or a TOML job that names one")
        ->required()
        ->option_text("(required)");
    const OptionGroup files(command, "Files and viewers"), sampling(command, "Sampling"), image(command, "Image"),
        schedule(command, "Long renders"), machine(command, "Machine"), method(command, "Light transport"),
        light_layers(command, "Layers of light"), sample_layers(command, "Other layers"),
        color(command, "Colour and previews"), filters(command, "Filters");
    files.add("-o,--output", options.output, "OUT.exr",
              "image file; default: the name of the scene or job with .exr, in the current folder");
    add_file_options(files, options.outputs);
    files.add("--stats", options.statistics, "OUT.json",
              "also writes statistics (times, ray counts and more) as JSON; -: writes them to standard output, and "
              "messages to standard error");
    add_sampling_options(sampling, options);
    add_image_options(image, options);
    add_schedule_options(schedule, options);
    add_command_output_options(command, options.commands, "Long renders");
    add_machine_options(machine, options);
    add_plugin_option(command, options.plugins);
    command.get_option("--plugin")->group("Machine");
    add_method_options(method, options);
    add_light_layer_options(light_layers, options);
    add_sample_layer_options(sample_layers, options);
    add_preview_options(color, options.outputs);
    add_color_space_options(color, options);
    add_filter_options(filters, options.outputs);
}

}  // namespace raylex::experiments
