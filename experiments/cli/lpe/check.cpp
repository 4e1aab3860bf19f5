// raylex lpe check: proves that channels partition the beauty, or shows all overlaps and gaps.
#include <algorithm>
#include <chrono>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "experiments/cli/lpe/layers.h"
#include "experiments/cli/lpe/picture.h"
#include "experiments/job/channels/label_doubts.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/algebra/wording/regex_printing.h"
#include "lpe/language/extensions.h"

namespace raylex::experiments {
namespace {

struct CheckOptions {
    DialectOption dialect;
    ChannelArguments channels;
    ChannelOutput output;
    ReaderOption reader;
    SceneOption scene;
    PathOptions paths;
    lpe::Words words;  // the paths that scene and options allow
    std::string of, what = "partition", rest;
    bool json = false;
};

const char* word_for(lpe::Verdict verdict) {
    switch (verdict) {
        case lpe::Verdict::partition:
            return "partition";
        case lpe::Verdict::missed:
            return "missed";
        case lpe::Verdict::counted_twice:
            return "counted twice";
        case lpe::Verdict::outside:
            return "outside";
    }
    return "";
}

/// Returns which channels are written for RenderMan itself, which lacks raylex's extensions.
Written written_for_renderman(const CheckOptions& options) {
    const auto written = [&](const char* format) {
        return options.output.format == format ||
               (options.output.format.empty() && options.output.path.ends_with(std::string(".") + format));
    };
    if (options.reader.value() != lpe::Reader::renderman) return Written::nothing;
    if (written("ini")) return Written::with_macros;
    return written("rib") || written("usda") || written("usd") ? Written::without_macros : Written::nothing;
}

/// Finds an expression of the paths that no layer counts, in the dialect of the application that reads the channels if
/// possible, otherwise for raylex.
void find_rest(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    const bool renderman = written_for_renderman(options) != Written::nothing ||
                           (set.of_renderman && options.reader.value() == lpe::Reader::renderman);
    const auto& layers = picture.layers;
    if (renderman) {
        auto rest = lpe::rest_expression(layers.sources, layers.whole, options.words, lpe::Reader::renderman);
        if (rest && *rest) {
            picture.rest = **rest;
            return;
        }
    }
    auto rest = lpe::rest_expression(layers.sources, layers.whole, options.words);
    if (!rest || !*rest) {
        picture.rest_note = "the remaining paths have no short expression (" +
                            (rest ? "at most " + std::to_string(lpe::longest_printed_expression) + " characters"
                                  : rest.error().message) +
                            ")";
        return;
    }
    picture.rest = **rest;
    std::string ours;
    for (const std::string& each : lpe::extensions_in(picture.rest)) ours += (ours.empty() ? "" : ", ") + each;
    if (renderman) picture.rest_note = "raylex reads it; RenderMan does not know " + ours;
    else if (std::any_of(layers.sources.begin(), layers.sources.end(),
                         [](const lpe::ChannelSource& each) { return each.dialect == lpe::Dialect::osl; }))
        picture.rest_note = "it is in the dialect renderman";
}

/// Finds the result for channels that are too large for a proof of all together: one overlapping pair suffices to
/// refute the partition.
Status judge_pairs(const CheckOptions& options, CheckPicture& picture, const Error& too_large) {
    const Layers& layers = picture.layers;
    auto overview = lpe::look_over(layers.sources, layers.whole, options.words);
    if (!overview || overview->overlaps.empty()) return too_large;
    picture.overview = std::move(*overview);
    const auto& overlaps = picture.overview.overlaps;
    const auto shortest = std::min_element(overlaps.begin(), overlaps.end(), [](const auto& a, const auto& b) {
        return a.witness.events.size() < b.witness.events.size();
    });
    picture.verdict = word_for(lpe::Verdict::counted_twice);
    picture.witness = shortest->witness;
    picture.summary = "'" + layers.sources[shortest->first].name + "' and '" + layers.sources[shortest->second].name +
                      "' both count " + picture.witness.sentence + " (" + picture.witness.text + ")";
    return success();
}

Status judge_partition(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    Layers& layers = picture.layers;
    auto report = lpe::check_partition(layers.sources, layers.whole, options.words);
    if (!report) return judge_pairs(options, picture, report.error());
    const bool fails = report->verdict != lpe::Verdict::partition;
    if (fails) {
        auto overview = lpe::look_over(layers.sources, layers.whole, options.words);
        if (!overview) return overview.error();
        picture.overview = std::move(*overview);
    }
    const bool only_missed = fails && picture.overview.overlaps.empty() && picture.overview.outside.empty();
    if (only_missed) {
        find_rest(options, set, picture);
        if (!options.rest.empty() && !picture.rest.empty()) {
            layers.sources.push_back(bare_expression(picture.rest, lpe::Dialect::renderman, options.rest, "--rest"));
            picture.overview = {};
            report = lpe::check_partition(layers.sources, layers.whole, options.words);
            if (!report) return report.error();
        }
    }
    picture.holds = report->verdict == lpe::Verdict::partition;
    picture.verdict = word_for(report->verdict);
    picture.summary = std::move(report->summary);
    picture.witness = std::move(report->witness);
    picture.warnings = std::move(report->warnings);
    return success();
}

/// Checks the layers that belong to no partition by themselves, because their overlaps and gaps are the ones to fix.
Status judge_left(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    const std::vector<std::size_t>& left = picture.sorting.left;
    CheckPicture alone;
    alone.layers.whole = picture.layers.whole;
    std::string names;
    for (const std::size_t channel : left) {
        const lpe::ChannelSource& source = picture.layers.sources[channel];
        names += (names.empty() ? "'" : ", '") + source.name + "'";
        alone.layers.sources.push_back(source);
    }
    CheckOptions plain = options;
    plain.rest.clear();
    if (Status judged = judge_partition(plain, set, alone); !judged) return judged;
    for (lpe::SharedPath& each : alone.overview.overlaps) {
        each.first = left[each.first];
        each.second = left[each.second];
    }
    for (lpe::OutsidePath& each : alone.overview.outside) each.channel = left[each.channel];
    for (std::size_t& each : alone.overview.empty) each = left[each];
    picture.overview = std::move(alone.overview);
    picture.rest = std::move(alone.rest);
    picture.rest_note = std::move(alone.rest_note);
    picture.verdict = std::move(alone.verdict);
    picture.summary = (left.size() <= 4 ? names : std::to_string(left.size()) + " layers") +
                      (left.size() == 1 ? " is" : " are") + " in no partition; these alone: " + alone.summary;
    picture.witness = std::move(alone.witness);
    return success();
}

/// Sorts overlapping layers into several partitions of the same beauty, for example by lobe and by light group. The
/// check holds if each layer belongs to one of them. Only layers from files are sorted; layers on the command line form
/// one split.
Status sort_layers(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    if (picture.holds || picture.files.empty() || picture.overview.overlaps.empty()) return success();
    auto sorting = lpe::sort_into_partitions(picture.layers.sources, picture.layers.whole, options.words);
    if (!sorting) return success();  // too large to sort: the result stays
    picture.sorting = std::move(*sorting);
    const lpe::Sorting& sorted = picture.sorting;
    if (sorted.partitions.empty()) return success();
    if (!sorted.left.empty()) return judge_left(options, set, picture);
    picture.holds = true;
    picture.verdict = "partitions";
    picture.summary = "the layers are " + std::to_string(sorted.partitions.size()) +
                      " partitions of the beauty, each of which counts every path exactly once";
    picture.overview = {};
    return success();
}

Status judge_disjoint(const CheckOptions& options, CheckPicture& picture, const std::string& rest) {
    auto report = lpe::check_disjoint(picture.layers.sources, options.words);
    if (!report) return report.error();
    if (!report->disjoint) {
        auto overview = lpe::look_over(picture.layers.sources, std::nullopt, options.words);
        if (!overview) return overview.error();
        picture.overview = std::move(*overview);
        picture.overview.holes.clear();
    }
    picture.holds = report->disjoint;
    picture.verdict = report->disjoint ? "disjoint" : "overlaps";
    picture.summary = report->summary + (report->disjoint && !rest.empty() ? "; '" + rest + "' takes the rest" : "");
    picture.witness = std::move(report->witness);
    picture.warnings = std::move(report->warnings);
    return success();
}

Status judge_covers(const CheckOptions& options, CheckPicture& picture) {
    auto proof = lpe::check_covers(picture.layers.sources, picture.layers.whole, options.words);
    if (!proof) return proof.error();
    if (!proof->holds) {
        auto overview = lpe::look_over(picture.layers.sources, picture.layers.whole, options.words);
        if (!overview) return overview.error();
        picture.overview.holes = std::move(overview->holes);
    }
    picture.holds = proof->holds;
    picture.verdict = proof->holds ? "covers" : "missed";
    picture.summary = std::move(proof->summary);
    picture.witness = std::move(proof->witness);
    picture.warnings = std::move(proof->warnings);
    return success();
}

/// Returns the channels of a partition by name. Errors: an unknown name.
Result<std::vector<lpe::ChannelSource>> members(const std::vector<lpe::ChannelSource>& sources,
                                                const PartitionRequest& partition,
                                                const std::vector<std::string>& wanted) {
    std::vector<lpe::ChannelSource> result;
    for (const std::string& name : wanted) {
        std::vector<std::string> known;
        for (const lpe::ChannelSource& source : sources) {
            known.push_back(source.name);
            if (source.name == name) result.push_back(source);
        }
        if (result.empty() || result.back().name != name)
            return error_at(partition.location,
                            "partition '" + partition.name + "' names the channel '" + name + "', which does not exist",
                            near_miss(name, known));
    }
    return result;
}

/// Checks each partition that the TOML files declare.
Result<std::vector<CheckPicture>> judge_declared(const CheckOptions& options, const ChannelSet& set,
                                                 const std::vector<lpe::ChannelSource>& sources) {
    std::vector<CheckPicture> pictures;
    for (const PartitionRequest& partition : set.partitions) {
        CheckPicture& picture = pictures.emplace_back();
        picture.partition = partition.name;
        picture.words = options.words;
        auto channels = members(sources, partition, partition.channels);
        if (!channels) return channels.error();
        picture.layers.sources = std::move(*channels);
        if (!partition.of.empty()) {
            auto found = members(sources, partition, {partition.of});
            if (!found) return found.error();
            picture.layers.whole = found->front();
        }
        const Status judged = partition.rest.empty() ? judge_partition(options, set, picture)
                                                     : judge_disjoint(options, picture, partition.rest);
        if (!judged) return judged.error();
    }
    return pictures;
}

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

/// Checks the partitions that TOML files declare, or else all layers together.
Result<std::vector<CheckPicture>> judge(const CheckOptions& options, const ChannelSet& set,
                                        std::vector<lpe::ChannelSource> sources, std::optional<lpe::ChannelSource> of) {
    const bool declared =
        !set.partitions.empty() && options.of.empty() && options.rest.empty() && options.what == "partition";
    if (declared) return judge_declared(options, set, sources);
    std::vector<CheckPicture> pictures(1);
    CheckPicture& picture = pictures.front();
    picture.channels = sources.size();
    picture.files = options.channels.files;
    picture.words = options.words;
    if (options.what == "partition" || of) {
        auto layers = choose_layers(set, std::move(sources), std::move(of), options.words);
        if (!layers) return layers.error();
        picture.layers = std::move(*layers);
    } else {
        picture.layers.sources = std::move(sources);
    }
    const Status judged = options.what == "covers"     ? judge_covers(options, picture)
                          : options.what == "disjoint" ? judge_disjoint(options, picture, "")
                                                       : judge_partition(options, set, picture);
    if (!judged) return judged.error();
    if (options.what == "partition")
        if (Status sorted = sort_layers(options, set, picture); !sorted) return sorted.error();
    return pictures;
}

/// Returns the channels of one file with the macros of the whole set. Several files are checked one by one, then
/// together.
ChannelSet part_of(const ChannelSet& set, const std::string& file) {
    ChannelSet part = set;
    std::erase_if(part.file.channels, [&](const lpe::FileChannel& each) {
        const std::pair<std::string, std::string> here{each.source.name, file};
        return each.source.origin != file &&
               std::find(set.also_in.begin(), set.also_in.end(), here) == set.also_in.end();
    });
    std::erase_if(part.partitions, [&](const PartitionRequest& each) { return each.location.file != file; });
    return part;
}

/// Returns one result for all channels; if several files have channels, first one result per file.
Result<std::vector<CheckPicture>> judge_files(const CheckOptions& options, const ChannelSet& set,
                                              const std::vector<lpe::ChannelSource>& sources,
                                              const std::optional<lpe::ChannelSource>& of) {
    std::vector<CheckPicture> pictures;
    CheckPicture all;
    std::size_t files = 0;
    all.holds = options.channels.named.empty() && options.rest.empty();
    for (const std::string& file : options.channels.files) {
        const ChannelSet part = part_of(set, file);
        if (part.file.channels.empty() || options.what != "partition") continue;
        CheckOptions alone = options;
        alone.channels.files = {file};
        alone.rest.clear();
        std::vector<lpe::ChannelSource> own;
        for (const lpe::FileChannel& each : part.file.channels)
            for (const lpe::ChannelSource& source : sources)
                if (each.source.name == source.name) own.push_back(source);
        auto judged = judge(alone, part, std::move(own), of);
        if (!judged) return judged;
        ++files;
        for (CheckPicture& picture : *judged) {
            all.holds = all.holds && picture.holds;
            all.layers.sources.insert(all.layers.sources.end(), picture.layers.sources.begin(),
                                      picture.layers.sources.end());
            picture.alone = picture.partition.empty();
            pictures.push_back(std::move(picture));
        }
    }
    if (files < 2) return judge(options, set, sources, of);
    std::vector<CheckPicture> together;
    if (all.holds) {  // a layer shared by several splits, such as emission, is not an overlap
        all.verdict = "partitions";
        all.files = options.channels.files;
        all.channels = sources.size();
        all.summary = "each of the " + std::to_string(files) + " files splits the beauty by itself";
        together.push_back(std::move(all));
    } else {
        auto judged = judge(options, set, sources, of);
        if (!judged) return judged;
        together = std::move(*judged);
        std::erase_if(together, [](const CheckPicture& each) { return !each.partition.empty(); });
    }
    std::move(together.begin(), together.end(), std::back_inserter(pictures));
    return pictures;
}

/// Warns of labels that no object or light of the scene has; without a scene, of labels that look misspelt.
Status warn_about_labels(const CheckOptions& options, const std::vector<lpe::ChannelSource>& sources,
                         const std::optional<SceneWords>& scene) {
    warn_about_scene(sources, scene);
    if (scene) return success();
    KnownLabels known;
    known.groups = options.words.light_groups;
    known.labels = options.words.object_labels;
    auto doubts = label_doubts(sources, known);
    if (!doubts) return doubts.error();
    for (const std::string& each : *doubts) print_warning(each);
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
    auto words = words_of(options.paths, *scene, *set, all);
    if (!words) return report_error(words.error());
    options.words = std::move(*words);
    if (Status warned = warn_about_labels(options, sources, *scene); !warned) return report_error(warned.error());
    auto pictures = judge_files(options, *set, sources, *of);
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
