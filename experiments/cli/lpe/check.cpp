// raylex lpe check: proves that channels partition the beauty, or shows all overlaps and gaps.
#include <memory>
#include <optional>
#include <utility>

#include "experiments/cli/lpe/check_results.h"
#include "experiments/job/channels/label_warnings.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"

namespace raylex::experiments {
namespace {

/// Returns the value of --of: a channel by name, or an expression that may use the files' macros.
Result<std::optional<lpe::ChannelSource>> find_whole(const CheckOptions& options, const ChannelSet& set,
                                                     const std::vector<lpe::ChannelSource>& sources) {
    if (options.of.empty()) return std::optional<lpe::ChannelSource>();
    for (const lpe::ChannelSource& source : sources)
        if (source.name == options.of) return std::optional(source);
    ChannelSet one;
    one.file.macros = set.file.macros;
    one.file.channels.emplace_back().source = bare_expression(options.of, options.dialect.value(), "", "--of");
    std::vector<std::string> warnings;
    auto expanded = expanded_channels(one, warnings);
    if (!expanded) return about_channel_name(expanded.error(), options.of, set);
    for (const std::string& warning : warnings) print_warning(warning);
    return std::optional(std::move(expanded->front()));
}

/// Warns of labels that no object or light of the scene has; without a scene, of labels that look misspelt.
Status warn_about_labels(const CheckOptions& options, const std::vector<lpe::ChannelSource>& sources,
                         const std::optional<ScenePathStrings>& scene) {
    warn_about_scene(sources, scene);
    if (scene) return success();
    KnownLabels known;
    known.groups = options.words.light_groups;
    known.labels = options.words.object_labels;
    auto warnings = label_warnings(sources, known);
    if (!warnings) return warnings.error();
    for (const std::string& each : *warnings) print_warning(each);
    return success();
}

int report_all(const std::vector<Error>& errors) {
    for (const Error& error : errors) report_error(error);
    if (errors.size() > 1) return report_error(std::to_string(errors.size()) + " errors in the channels");
    return exit_bad_input;
}

int finish(const CheckOptions& options, ChannelSet& set, const std::vector<CheckPicture>& pictures) {
    int code = exit_holds;
    for (const CheckPicture& picture : pictures) {
        if (!options.json) print_picture(picture);
        code = picture.holds || picture.alone ? code : exit_does_not_hold;
    }
    if (options.json) print_line(pictures_as_json(pictures));
    if (options.output.path.empty()) return code;
    const std::vector<lpe::ChannelSource>& layers = pictures.back().layers.sources;
    if (!options.rest.empty() && layers.back().name == options.rest)
        set.file.channels.emplace_back().source = layers.back();
    if (Status written = write_channels(set, options.output, options.reader.value()); !written)
        return report_error(written.error());
    return code;
}

int run_check(CheckOptions options) {
    if (options.json && is_standard_output(options.output.path))
        return report_error("--json and -o - both write to standard output; expected a file name after -o");
    take_standard_output_for(options.output.path);
    if (Status taken = take_channel_files(options.channels); !taken) return report_error(taken.error());
    auto set = read_channel_set(options.channels, options.dialect.value(), true);
    if (!set) return report_error(set.error());
    if (set->file.channels.empty() && set->errors.empty())
        return report_error(resolved_channels(*set, options.channels).error());
    std::vector<Error> errors;
    const std::vector<lpe::ChannelSource> sources =
        read_all(*set, errors, options.reader.value(), written_for_renderman(options));
    if (!errors.empty()) return report_all(errors);
    for (const lpe::ChannelSource& source : sources)
        if (source.name == options.rest)
            return report_error("--rest " + options.rest +
                                ": a channel already has this name; expected a different name");
    auto of = find_whole(options, *set, sources);
    if (!of) return report_error(of.error());
    if (*of && options.what == "disjoint")
        return report_error("--of cannot be combined with --what disjoint; expected partition or covers");
    auto scene = options.scene.load();
    if (!scene) return report_error(scene.error());
    std::vector<lpe::ChannelSource> all = sources;
    if (*of) all.push_back(**of);
    auto words = path_strings_of(options.paths, *scene, *set, all);
    if (!words) return report_error(words.error());
    options.words = std::move(*words);
    if (Status warned = warn_about_labels(options, sources, *scene); !warned) return report_error(warned.error());
    auto pictures = check_files(options, *set, sources, *of);
    if (!pictures) return report_error(pictures.error());
    return finish(options, *set, *pictures);
}

}  // namespace

void add_lpe_check_commands(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<CheckOptions>();
    CLI::App* check = lpe.add_subcommand(
        "check",
        "Proves that the channels partition the beauty, or shows every overlap and every kind of path missed.");
    add_channel_arguments(*check, options->channels);
    check
        ->add_option("--what", options->what,
                     "partition (default): exactly one channel counts each path; disjoint: no two channels count the "
                     "same path; covers: at least one channel counts each path")
        ->option_text("partition|disjoint|covers")
        ->check(CLI::IsMember({"partition", "disjoint", "covers"}));
    check
        ->add_option("--of", options->of,
                     "the paths that are split, as an expression or a channel name; default: the channel of a file "
                     "that denotes the beauty, else every path that a scene can produce. Channels of files that equal "
                     "it or the beauty do not count as layers")
        ->option_text("BEAUTY");
    check
        ->add_option("--rest", options->rest,
                     "if the channels share no path, adds a channel NAME with the remaining paths before the proof")
        ->option_text("NAME");
    check->add_flag("--json", options->json, "prints the complete result as JSON");
    add_path_options(*check, options->paths);
    add_channel_output(*check, options->output,
                       "also writes the channels, in any format, even if the check fails. -: writes them to standard "
                       "output, and messages to standard error");
    add_reader_option(*check, options->reader);
    add_scene_option(*check, options->scene);
    add_dialect_option(*check, options->dialect);
    check->footer(
        "Example: raylex lpe check show.rib\n"
        "If a TOML file declares partitions, each is proved; otherwise all channels together. Channels of files are "
        "not layers if they\nhave prefixes (noclamp;, ...) or statistics (mse, variance, even, odd), or are the beauty "
        "itself. Files may hold several splits of\nthe same beauty (by lobe, by light group): the check holds if each "
        "layer belongs to one of them. Several files hold if each file\nholds alone, or if all channels hold "
        "together.\n"
        "If a check fails, the last line is the shortest counterexample, in the form that 'raylex lpe match' reads.\n"
        "See also: lpe equal, contains and empty for single expressions.\n"
        "Exit codes: 0 proved, 1 a path is missed, counted twice or outside, 2 bad usage or input; all expressions "
        "with\nerrors are named.");
    check->callback([options, &context] { context.exit_code = run_check(*options); });
}

}  // namespace raylex::experiments
