#include "experiments/cli/render/render_options.h"

#include <charconv>

#include "experiments/cli/option_group.h"
#include "experiments/cli/plugin_options.h"
#include "geoaovs/geoaovs.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {
namespace {

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

std::string effect_names() {
    std::string names;
    for (const transport::EffectInfo& each : transport::effect_catalogue())
        names += (names.empty() ? "" : ", ") + std::string(each.name);
    return names;
}

void add_sampling_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--spp", options.spp, "N", "samples per pixel; default: as the scene says")
        ->check(CLI::Range(1, 2147483647));
    group.add(
        "--until-error", options.until_error, "E",
        "samples each pixel until its standard error is at most E of its value, such as 1%: of the beauty, without one "
        "of every layer of light; --spp is then the "
        "most that a pixel may have, default 65536; [adaptive] in a job says more");
    group.add("--time", options.time, "TIME",
              "renders for so long, such as 30s, 5m or 1h, to within a second; --spp is then the most. The "
              "samples reached are printed: --spp with their number gives the same bits");
    group.add("--seed", options.seed, "N", "seed of the sampler; default 0")
        ->check(CLI::Validator(refuse_seed, "", "seed"));
    group.add("--sampler", options.sampler, "NAME", "sampler; default: as the scene says");
    group.add("--replay", options.replay, "X,Y,SAMPLE",
              "renders one sample of one pixel alone and prints what every layer gets and what is refused; writes "
              "nothing; exit code 1 when something is refused");
}

void add_image_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--resolution", options.resolution, "WxH", "image size in pixels; default: as the scene says");
    group.add(
        "--crop", options.crop, "X0,Y0,X1,Y1",
        "renders these pixels alone, to the bits that they have in the whole image: the file's data window in its "
        "display window");
    group.add("--filter", options.filter, "NAME", "pixel filter; default: as the scene says");
    group.add(
        "--missing", options.missing, "error|placeholder",
        "what a texture, light's image or mesh does whose file is missing: error (default), or placeholder, which "
        "renders with magenta in its place, counted in warnings and in the image's header");
    group
        .add("--filter-mode", options.filter_mode, "MODE",
             "importance (default): samples are drawn as the pixel filter says and belong to one pixel; splat: they "
             "are drawn evenly and shared by all pixels that the filter reaches, which leaves no statistics, deep "
             "images or cryptomattes")
        ->check(CLI::IsMember({"importance", "splat"}));
}

void add_schedule_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--checkpoint", options.checkpoint, "TIME",
              "saves the render to OUT.exr.checkpoint every so often, such as 60s, 5m or 1h, and at Ctrl-C; the file "
              "is removed once the image is written");
    group.add_flag("--resume", options.resume,
                   "goes on from OUT.exr.checkpoint to the same bits as if nothing had happened, saving every 60s or "
                   "as --checkpoint says");
    group.add(
        "--shard", options.shard, "PART/PARTS",
        "renders some of the samples alone, such as 2/4, to OUT.exr.shard-2-of-4, and nothing when that is there; "
        "begun again it goes on from its checkpoint. 'raylex merge' makes the image of all shards, the bits of "
        "one render");
    group
        .add("--shards", options.shards, "N",
             "with --commands: prints the commands for so many shards, and that which merges them, with the memory, "
             "CPU seconds and cores that each takes")
        ->check(CLI::Range(1U, 100000U));
}

void add_machine_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--threads", options.threads, "N", "threads; 0, the default, is all the machine offers")
        ->check(CLI::Range(0, 4096));
    group.add("--isa", options.isa, "NAME",
              "instruction set: sse2, sse4.2, avx, avx2 or avx512; default: the best there is");
    group.add("--memory-limit", options.outputs.memory_limit, "SIZE",
              "refuses a render whose layers need more, such as 8G; default none");
    group.add(
        "--memory", options.memory, "SIZE",
        "what the whole program may take, such as 2GiB: an image that needs more is rendered in buckets, bands of "
        "its rows, each saved in the folder OUT.exr.checkpoint once it is finished; same bits. --resume goes on "
        "with the buckets that are not there; default no limit");
    group.add("--bucket-rows", options.bucket_rows, "N", "renders in buckets of N rows, whether or not the image fits")
        ->check(CLI::Range(1, 65536));
}

void add_method_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--integrator", options.integrator, "NAME",
              "path, lighttracer, bdpt, pssmlt or a plugin's; default: as the scene says");
    group.add("--max-depth", options.max_depth, "N", "at most N scattering events on a path")
        ->check(CLI::Range(0, 2147483647));
    group.add_repeated("--effect", options.effects, "NAME=on|off",
                       "forces an effect off that the scene calls for, to see what it costs and brings, or on where "
                       "nothing calls for it, to see what its absence saves: " +
                           effect_names());
    group.add_flag("--effects", options.show_effects, "prints every effect: whether it is simulated, and why");
}

void add_light_layer_options(const OptionGroup& group, RenderOptions& options) {
    add_expression_options(group, options);
    group.add("--techniques", options.techniques, "pyramid[:CHANNEL,...]",
              "'pyramid' adds a layer of beauty for each way to find a path, s vertices from the light and t from "
              "the camera (beauty_s1t3), with its MIS weight and without (beauty_s1t3_unweighted); "
              "'pyramid:CHANNEL,...' of these channels");
    group.add_flag("--no-beauty", options.no_beauty, "renders only what the layers need");
    group
        .add("--prune", options.prune, "WHEN",
             "on (default): without beauty, light paths that no layer takes are not simulated; off: they are, to see "
             "what that saves")
        ->check(CLI::IsMember({"on", "off"}));
}

void add_sample_layer_options(const OptionGroup& group, RenderOptions& options) {
    group
        .add_repeated("--aov", options.aovs, "NAME[,NAME...]",
                      "adds geometric AOVs by their standard names (" + aov_names() +
                          "), the channels that textures of the scene name, or those that plugins declare")
        ->delimiter(',');
    group.add_repeated("--channel", options.declared, "NAME:TYPE",
                       "adds a layer that plugins, patterns and materials write to by its name; TYPE is float, rgb, "
                       "point, normal, vector or integer");
    group.add_repeated(
        "--rule", options.rules, "NAME=RULE",
        "how the samples of a channel become its pixels: filter (the pixel filter), zmin, zmax (the nearest, "
        "farthest sample), min, max, average or sum");
    group.add_repeated(
        "--layer", options.layers, "NAME=CHANNEL:RULE",
        "adds a layer with the samples of a channel, or of the beauty, made pixels by another rule (as --rule has "
        "them)");
    group.add_repeated(
        "--statistics", options.statistic_layers, "NAME=STATISTIC,...",
        "adds layers NAME_variance (of the samples), NAME_mse (variance of the pixel), NAME_even and NAME_odd "
        "(the image from samples of even, odd index) for the beauty or a filtered channel");
    group
        .add_repeated("--cryptomatte", options.cryptomatte, "KIND[,KIND...]",
                      "adds cryptomattes of these kinds: object, material, asset; not with pixel filters that have "
                      "negative lobes")
        ->delimiter(',');
    group
        .add("--cryptomatte-ranks", options.cryptomatte_ranks, "N",
             "how many ids a cryptomatte keeps per pixel, an even number; default 6")
        ->check(CLI::Range(2, geoaovs::Cryptomatte::most_ranks))
        ->check(CLI::Validator(refuse_odd, "", "even"));
}

void add_color_space_options(const OptionGroup& group, RenderOptions& options) {
    group.add("--ocio", options.ocio, "FILE",
              "OpenColorIO config; default: $OCIO, else the one that ships with raylex");
    group.add("--rendering-space", options.rendering_space, "NAME",
              "scene-linear space of the config to render in; default: the scene's own");
}

}  // namespace

void add_render_options(CLI::App& command, RenderOptions& options) {
    command.add_option("SCENE.pbrt|JOB.toml", options.input, "a pbrt-v4 scene, or a TOML job that names one")
        ->required()
        ->option_text("(required)");
    const OptionGroup files(command, "Files and viewers"), sampling(command, "Sampling"), image(command, "Image"),
        schedule(command, "Long renders"), machine(command, "Machine"), method(command, "Light transport"),
        light_layers(command, "Layers of light"), sample_layers(command, "Other layers"),
        color(command, "Colour and previews"), filters(command, "Filters");
    files.add("-o,--output", options.output, "OUT.exr",
              "image to write; default: the scene's or job's name with .exr, here");
    add_file_options(files, options.outputs);
    files.add("--stats", options.statistics, "OUT.json",
              "also writes times, ray counts and the like as JSON; -: to standard output, and what is said to standard "
              "error");
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
