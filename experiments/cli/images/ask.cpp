// raylex ask: makes layers from an atlas, and lists the brightest words of pixels, without tracing rays.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/output/atomic_file.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "display/output/writer/exr_writer.h"
#include "experiments/atlas/answer.h"
#include "experiments/atlas/merged_atlas.h"
#include "experiments/atlas/top_contributions.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/expression_options.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/columns.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/tint.h"

namespace raylex::experiments {
namespace {

struct AskOptions {
    std::vector<std::string> files;
    std::string output, at, mix;
    std::vector<std::string> colors, lights;
    std::optional<int> top, suggest;
    bool intervals = false, errors = false, merge = false;

    [[nodiscard]] bool mixes() const { return !mix.empty() || !colors.empty() || !lights.empty(); }
};

Error option_error(const std::string& option, const std::string& message, const std::string& hint = {}) {
    return error_at({option, 0, 0}, message, hint);
}

Status check_options(const CLI::App& command, const AskOptions& options) {
    const bool layers = has_expressions(command) || options.mixes(), pixel = options.top || !options.at.empty();
    const int requested = (layers ? 1 : 0) + (pixel ? 1 : 0) + (options.suggest ? 1 : 0) + (options.merge ? 1 : 0);
    if (requested == 0)
        return option_error("ask",
                            "no question; expected --lpe, --channels, --partition, --light-groups, --what-if, --light "
                            "or --mix with -o, or --top, --suggest, or --merge with -o");
    if (requested > 1)
        return option_error("ask",
                            "layers, --top, --suggest and --merge exclude one another; "
                            "expected one of them at a time");
    if (!options.merge && options.files.size() != 1)
        return option_error("ask", std::to_string(options.files.size()) + " files are given; expected one atlas",
                            "--merge combines several atlases into one");
    if (options.merge && options.files.size() < 2)
        return option_error("--merge", "one atlas cannot be merged; expected at least two");
    if (!options.top && !options.at.empty())
        return option_error("--at", "--at needs the number of path strings; expected --top as well, such as --top 20");
    if (layers != !options.output.empty() && !options.merge)
        return option_error("-o", layers ? "layers need a file; expected -o LAYERS.exr"
                                         : "-o is used only with layers or --merge; expected no -o");
    if (options.merge && options.output.empty())
        return option_error("-o", "a merged atlas needs a file; expected -o MERGED.atlas.exr");
    if (options.output.empty()) return success();
    return check_new_exr(options.output, options.files);
}

std::string triple(const std::array<float, 3>& rgb) {
    return "(" + number_text(static_cast<double>(rgb[0])) + ", " + number_text(static_cast<double>(rgb[1])) + ", " +
           number_text(static_cast<double>(rgb[2])) + ")";
}

std::string with_error(double value, double error) {
    return number_text(value) + (std::isfinite(error) ? " +- " + number_text(error, 2) : " +- unknown");
}

/// Prints the brightest words of a pixel.
Status print_pixel(display::AtlasFile& atlas, int x, int y, std::size_t most) {
    const auto pixel = top_contributions(atlas, x, y, most);
    if (!pixel) return pixel.error();
    print_line("pixel (" + std::to_string(x) + ", " + std::to_string(y) +
               "): " + triple({pixel->rgba[0], pixel->rgba[1], pixel->rgba[2]}) + ", mean " +
               with_error(pixel->mean, pixel->error) + ", " + number_text(pixel->samples, 6) + " samples");
    for (const TopContribution& word : pixel->words) {
        const double share = pixel->mean != 0 ? 100 * word.mean / pixel->mean : 0;
        print_line("  " + padded(number_text(share) + " %", 9) + padded(with_error(word.mean, word.error), 24) +
                   path_string_text(atlas.table(), word.word));
    }
    if (pixel->more > 0) print_line("  and " + counted(pixel->more, "more word"));
    return success();
}

/// Prints the image's brightest outliers with the brightest words of each, for --top without --at.
int tell_outliers(display::AtlasFile& atlas, std::size_t most) {
    constexpr std::size_t words_of_each = 2;
    const auto pixels = brightest_outliers(atlas, most);
    if (!pixels) return report_error(pixels.error());
    if (pixels->empty()) print_line("no pixel is brighter than the median of its neighbours");
    for (const auto& [x, y] : *pixels)
        if (Status printed = print_pixel(atlas, x, y, words_of_each); !printed) return report_error(printed.error());
    return exit_holds;
}

int tell_pixel(display::AtlasFile& atlas, const AskOptions& options) {
    int x = 0, y = 0;
    const char* const end = options.at.data() + options.at.size();
    const auto first = std::from_chars(options.at.data(), end, x);
    const bool comma = first.ec == std::errc() && first.ptr != end && *first.ptr == ',';
    if (!comma || std::from_chars(first.ptr + 1, end, y).ptr != end || end[-1] == ',')
        return report_error(option_error("--at", "'" + options.at + "' is not a pixel; expected X,Y, such as 12,7"));
    const Status printed = print_pixel(atlas, x, y, static_cast<std::size_t>(*options.top));
    return printed ? exit_holds : report_error(printed.error());
}

int tell_suggestion(display::AtlasFile& atlas, const AskOptions& options) {
    const auto layers = suggest_partition(atlas, static_cast<std::size_t>(*options.suggest));
    if (!layers) return report_error(layers.error());
    if (layers->empty())
        return report_error(
            error_at({atlas.path(), 0, 0},
                     "the noise cannot be estimated from so few samples; expected at least two per pixel"));
    std::size_t width = 4;
    for (const SuggestedLayer& layer : *layers) width = std::max(width, layer.name.size());
    std::string flags;
    print_line(padded("layer", width) + "  noise   light   expression");
    for (const SuggestedLayer& layer : *layers) {
        print_line(padded(layer.name, width) + "  " + padded(number_text(100 * layer.noise) + " %", 8) +
                   padded(number_text(100 * layer.light) + " %", 8) +
                   (layer.expression.empty() ? "all other light" : layer.expression));
        if (!layer.expression.empty()) flags += " --lpe " + shell_command({layer.name + "=" + layer.expression});
    }
    print_line("raylex ask " + shell_command({atlas.path()}) + flags + " -o layers.exr");
    return exit_holds;
}

int merge_files(const AskOptions& options) {
    auto merged = MergedAtlas::open(options.files);
    if (!merged) return report_error(merged.error());
    if (Status written = display::write_atlas(options.output, **merged, (*merged)->description()); !written)
        return report_error(written.error());
    auto file = display::AtlasFile::open(options.output);
    if (!file) return report_error(file.error());
    return report_atlas_check(**file);
}

/// Warns of everything in channel files that an atlas does not have, and removes it from the job.
void leave_out_no_light(Job& job) {
    const auto left = [](const std::string& what) {
        print_warning("an atlas contains only light; " + what + " is left out");
    };
    for (const AovRequest& aov : job.aovs) left("'" + aov.name + "'");
    for (const display::ChannelDefinition& channel : job.declared) left("'" + channel.name + "'");
    for (const display::LayerRequest& layer : job.settings.channels.layers) left("'" + layer.name + "'");
    for (const display::RuleRequest& rule : job.settings.channels.rules) left("the rule of '" + rule.channel + "'");
    if (!job.settings.mattes.kinds.empty()) left("cryptomatte");
    job.aovs.clear();
    job.declared.clear();
    job.settings.channels.layers.clear();
    job.settings.channels.rules.clear();
    job.settings.mattes.kinds.clear();
}

Result<Mix> mix_of(const AskOptions& options) {
    Mix mix;
    if (!options.mix.empty())
        if (Status read = read_mix(options.mix, mix); !read) return read.error();
    if (Status added = add_factors(options.colors, "--what-if", mix.colors); !added) return added.error();
    if (Status added = add_factors(options.lights, "--light", mix.lights); !added) return added.error();
    return mix;
}

int write_layers(const CLI::App& command, display::AtlasFile& atlas, const AskOptions& options,
                 const CommandContext& context) {
    Job job;
    if (Status read = read_expressions(command, job); !read) return report_error(read.error());
    leave_out_no_light(job);
    auto mix = mix_of(options);
    if (!mix) return report_error(mix.error());
    auto answered = answer_question(atlas, job, {options.intervals, options.errors, *std::move(mix)});
    if (!answered) return report_error(answered.error());
    for (const std::string& note : answered->notes) print_warning(note);
    if (!answered->refuted.empty()) {
        std::fprintf(stderr, "raylex: %s\nNothing was written.\n", answered->refuted.c_str());
        return exit_does_not_hold;
    }
    answered->description.attributes["raylex/asked"] = shell_command(context.arguments);
    const RequestedLayers& layers = answered->layers;
    std::vector<display::SplitResult> results;
    if (Status written =
            display::write_exr(options.output, layers, RequestedLayers::beauty, answered->description, &results);
        !written)
        return report_error(written.error());
    bool hold = true;
    for (const display::SplitResult& result : results) {
        print_result(result_line(result), result.holds);
        hold = hold && result.holds;
    }
    print_line(options.output + ": " + std::to_string(atlas.width()) + "x" + std::to_string(atlas.height()) + ", " +
               counted(layers.channels().size(), "layer") + " from " +
               counted(atlas.table().words.size(), "path string"));
    return hold ? exit_holds : exit_does_not_hold;
}

int ask(const CLI::App& command, const AskOptions& options, const CommandContext& context) {
    if (Status good = check_options(command, options); !good) return report_error(good.error());
    if (options.merge) return merge_files(options);
    auto atlas = display::AtlasFile::open(options.files.front());
    if (!atlas) return report_error(atlas.error());
    if (!(*atlas)->description().complete)
        print_warning((*atlas)->path() + " comes from an interrupted render, so its pixels have fewer samples");
    if (options.top && options.at.empty()) return tell_outliers(**atlas, static_cast<std::size_t>(*options.top));
    if (options.top) return tell_pixel(**atlas, options);
    if (options.suggest) return tell_suggestion(**atlas, options);
    return write_layers(command, **atlas, options, context);
}

}  // namespace

void add_ask_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "ask", "Makes layers for light path expressions from the atlas of a render, without tracing rays.");
    auto options = std::make_shared<AskOptions>();
    command->add_option("FILE.atlas.exr", options->files, "the file of raylex render --atlas; several with --merge")
        ->required()
        ->option_text("...");
    const OptionGroup layers(*command, "Layers"), edits(*command, "What if"), why(*command, "Why"),
        files(*command, "Files");
    add_expression_options(layers);
    layers.add_flag("--intervals", options->intervals,
                    "if the atlas cannot compute a layer exactly, or merges path strings that --what-if changes "
                    "differently, writes the bounds NAME_least and NAME_most instead; default: an error");
    layers.add_flag(
        "--errors", options->errors,
        "adds a layer NAME_error for each layer and the beauty: the standard error of (R + G + B) / 3 in each "
        "pixel");
    edits.add_repeated("--what-if", options->colors, "OBJECT.LOBE=FACTOR",
                       "multiplies the colour of an object's lobe by 0.5, or by 0.5,0.2,0.2 for red, green and blue; "
                       "LOBE: D diffuse, S glossy or specular, V phase, or the lobe's name");
    edits.add_repeated("--light", options->lights, "GROUP=FACTOR",
                       "multiplies the light of a group by such a factor, or by +1stop; default: lights without a "
                       "group");
    edits.add("--mix", options->mix, "FILE.toml", "factors from the tables [light] and [what_if] of a file");
    why.add("--top", options->top, "N",
            "prints the N brightest path strings of the pixel --at, with standard errors of (R + G + B) / 3; without "
            "--at: "
            "the N pixels that exceed the median of their neighbours most, with their brightest path strings")
        ->check(CLI::Range(1, 1000000));
    why.add("--at", options->at, "X,Y", "the pixel, counted from the top left corner");
    why.add("--suggest", options->suggest, "N",
            "prints a partition with N layers for the noisiest paths and a rest, and the command that makes it")
        ->check(CLI::Range(1, 200));
    files.add_flag(
        "--merge", options->merge,
        "merges several atlases into one: renders of a scene with different seeds, or the shards of a render");
    files.add("-o,--output", options->output, "OUT.exr", "file for the layers, or for the merged atlas");
    command->footer(
        "The layers have the names, headers and partitions of a render with the same options, and its values up "
        "to\nrounding; raylex verify checks the file. Exit codes: 0 success and all partitions sum, 1 a partition does "
        "not "
        "hold,\n"
        "2 bad usage or input, or a question that the atlas cannot answer. experiments/docs/atlas.md has the "
        "rest.");
    command->callback([command, options, &context] { context.exit_code = ask(*command, *options, context); });
}

}  // namespace raylex::experiments
