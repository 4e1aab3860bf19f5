// raylex lpe split: writes channels that partition the light, and proves that they do.
#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "experiments/cli/lpe/commands.h"
#include "experiments/job/channels/named_labels.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/channels/split.h"

namespace raylex::experiments {
namespace {

struct SplitOptions {
    DialectOption dialect;
    ChannelArguments channels;
    std::vector<std::string> by;
    lpe::SplitRequest request;
    ChannelOutput output;
    ReaderOption reader;
    SceneOption scene;
    std::string of, partition = "split", preset;
    bool no_volume = false, all_labelled = false;
};

/// Returns the split as a channel set, which any format can store; TOML also stores the partition.
ChannelSet as_set(const SplitOptions& options, const lpe::Split& split) {
    ChannelSet set;
    PartitionRequest partition;
    partition.name = options.partition;
    if (split.of) {
        lpe::FileChannel of;
        of.source = *split.of;
        of.source.name = split.of->name.empty() ? "whole" : split.of->name;
        of.comment = "the light that the channels below split";
        partition.of = of.source.name;
        set.file.channels.push_back(std::move(of));
    }
    for (const lpe::ChannelSource& source : split.channels) {
        lpe::FileChannel channel;
        channel.source = source;
        partition.channels.push_back(source.name);
        set.file.channels.push_back(std::move(channel));
    }
    set.partitions.push_back(std::move(partition));
    return set;
}

/// Checks that the scene has all names of an option. Errors: all unknown names, with their closest matches.
Status require_known(const SplitOptions& options, const char* option, const std::string& what,
                     const std::vector<std::string>& named, const std::vector<std::string>& known) {
    std::set<std::string> there(known.begin(), known.end());
    there.erase("");
    std::string lacking;
    for (const std::string& name : named)
        if (!there.contains(name)) lacking += (lacking.empty() ? "'" : ", '") + name + "'" + did_you_mean(name, there);
    if (lacking.empty()) return success();
    const std::string list = there.empty() ? "none" : lpe::joined_by({there.begin(), there.end()}, ", ");
    return error_at({option, 0, 0},
                    options.scene.path + " has no " + what + " " + lacking + "; expected some of: " + list);
}

int run_split(SplitOptions options) {
    const auto start = std::chrono::steady_clock::now();
    lpe::SplitRequest& request = options.request;
    for (const std::string& word : options.by) {
        auto axis = lpe::parse_split_axis(word);
        if (!axis) return report_error(about_argument(axis.error(), "--by", ""));
        request.by.push_back(*axis);
    }
    if (request.by.empty() && options.preset.empty())
        return report_error("the split has no axis; expected --by AXIS,... or --preset compositing");
    request.dialect = options.dialect.value();
    auto scene = options.scene.load();
    if (!scene) return report_error(scene.error());
    request.words = path_strings_of(*scene);
    if (*scene) {
        const auto& alphabet = (*scene)->alphabet;
        if (Status there = require_known(options, "--groups", "light group", request.groups, alphabet.light_groups);
            !there)
            return report_error(there.error());
        if (Status there = require_known(options, "--objects", "object label", request.objects, alphabet.object_labels);
            !there)
            return report_error(there.error());
        if (request.groups.empty()) request.groups = alphabet.light_groups;
    }
    std::erase(request.groups, "");
    request.words.volume = !options.no_volume;
    request.words.unlabelled_lights = !options.all_labelled;
    if (!options.preset.empty()) {
        std::string prefix = std::move(request.prefix);
        request = lpe::compositing_split(request.groups, request.dialect, request.words);
        request.prefix = std::move(prefix);
    }
    if (!options.of.empty()) {
        auto of = channel_or_expression(options.of, options.channels, request.dialect, "--of");
        if (!of) return report_error(of.error());
        request.of = std::move(*of);
    }
    auto split = lpe::generate_split(request);
    if (!split) return report_error(split.error());
    if (Status written = write_channels(as_set(options, *split), options.output, options.reader.value()); !written)
        return report_error(written.error());
    for (const std::string& note : split->notes) print_warning(note);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    print_note(split->summary + " (" + duration_text(seconds) + ")");
    return exit_holds;
}

void add_axes(CLI::App& split, SplitOptions& options) {
    CLI::Option* preset =
        split
            .add_option("--preset", options.preset,
                        "compositing: light group, direct or indirect, and diffuse, specular, transmission, subsurface "
                        "or volume; light seen directly is in 'emission'")
            ->option_text("compositing")
            ->check(CLI::IsMember({"compositing"}));
    const auto list = [&](const char* name, std::vector<std::string>& to, const char* description, const char* text) {
        return split.add_option(name, to, description)
            ->option_text(text)
            ->delimiter(',')
            ->expected(1)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    };
    list(
        "--by", options.by,
        "axes of the split, in the order of the parts of a channel's name: light-group, lobe, bounce, object, terminal",
        "AXIS[,AXIS...]")
        ->excludes(preset);
    list("--groups", options.request.groups,
         "light groups, for the axis light-group; all other lights are in 'default'; default: those of --scene",
         "NAME[,NAME...]");
    list("--lobes", options.request.lobes,
         "lobes of the first scattering, for the axis lobe: events such as RD, S4, T, V or coat=S4, or lobe names such "
         "as "
         "coat; default RD,RS,TD,TS,V",
         "LOBE[,LOBE...]")
        ->excludes(preset);
    list("--objects", options.request.objects,
         "labels of the first object, for the axis object; all others are in 'other'", "NAME[,NAME...]")
        ->excludes(preset);
    split.add_option("--bounces", options.request.bounces, "bins of the axis bounce, the last open-ended; default 3")
        ->option_text("N")
        ->check(CLI::Range(1, 64))
        ->excludes(preset);
}

}  // namespace

void add_lpe_split_commands(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<SplitOptions>();
    CLI::App* split = lpe.add_subcommand("split",
                                         "Writes channels that split all light by light group, lobe, bounce and more, "
                                         "with a proof that they are a partition.");
    add_axes(*split, *options);
    split
        ->add_option(
            "--of", options->of,
            "the light that is split: an expression, or the name of a channel in --channels; default: the beauty")
        ->option_text("BEAUTY");
    add_channel_output(*split, options->output, "file to write; default (also -): standard output, as TOML");
    add_reader_option(*split, options->reader);
    split->add_option("--prefix", options->request.prefix, "prefix of every channel's name")->option_text("TEXT");
    split->add_option("--partition", options->partition, "name of the partition in TOML; default split")
        ->option_text("NAME");
    split->add_flag("--no-volume", options->no_volume, "excludes paths that scatter in media (event V)");
    split->add_flag("--all-labelled", options->all_labelled,
                    "every light has a group; required by osl, which cannot express lights without a group");
    add_channel_files(*split, options->channels);
    add_scene_option(*split, options->scene);
    add_dialect_option(*split, options->dialect);
    split->footer(
        "Light seen directly is in the bin 'visible' of the axes lobe, object and bounce; emission is in the light "
        "group "
        "'default'.\n"
        "With --bounces 2 the bins are 'direct' and 'indirect'. The result of the proof is printed to standard error.\n"
        "Examples: raylex lpe split --by light-group,lobe --groups key,fill -o split.toml\n"
        "          raylex lpe split --preset compositing --scene scene.pbrt -o layers.toml\n"
        "Exit codes: 0 written and proved, 2 bad usage or input, or the proof failed.");
    split->callback([options, &context] { context.exit_code = run_split(*options); });
}

}  // namespace raylex::experiments
