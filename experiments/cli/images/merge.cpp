// raylex merge: combines the shards of a render into its image.
#include <algorithm>
#include <memory>

#include "display/output/atomic_file.h"
#include "experiments/atlas/merged_atlas.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/work_lock.h"
#include "experiments/shards/merge_shards.h"

namespace raylex::experiments {
namespace {

struct ImageMergeOptions {
    std::vector<std::string> records, plugins;
    std::string output, atlas;
    unsigned shards = 0;
    bool wait = false;
};

/// Returns the records on the command line and those of --shards.
std::vector<std::string> records_of(const ImageMergeOptions& options) {
    std::vector<std::string> records = options.records;
    for (unsigned part = 1; part <= options.shards; ++part)
        records.push_back(shard_file(options.output, part, options.shards));
    return records;
}

/// Merges the atlases beside the records into one and returns the exit code.
int merge_atlases(const std::string& output, const MergedRender& merged) {
    std::vector<std::string> files;
    for (const auto& [part, parts] : merged.parts) files.push_back(shard_file(output, part, parts));
    auto atlas = MergedAtlas::open(files);
    if (!atlas) return report_error(atlas.error());
    const display::ImageDescription description = (*atlas)->description();
    // Any of the files can come from another program, so missing attributes count as different.
    const auto said = [](const display::ImageDescription& by, const char* name) {
        const auto found = by.attributes.find(name);
        return found == by.attributes.end() ? std::string() : found->second;
    };
    for (const char* name : {"raylex/scene", "raylex/job", "raylex/seed", "raylex/samples_per_pixel"})
        if (said(description, name) != said(merged.image.description, name))
            return report_error(
                error_at({files.front(), 0, 0},
                         "this atlas, or one beside it, belongs to another render than the records: they differ in " +
                             std::string(name),
                         "expected the atlases that 'raylex render --shard' left with the records"));
    if (Status written = display::write_atlas(output, **atlas, description); !written)
        return report_error(written.error());
    auto file = display::AtlasFile::open(output);
    if (!file) return report_error(file.error());
    return report_atlas_check(**file);
}

int merge_records(const ImageMergeOptions& options, const std::vector<std::string>& arguments) {
    if (Status good = check_new_exr(options.output); !good) return report_error(good.error());
    if (Status loaded = load_plugins(options.plugins); !loaded) return report_error(loaded.error());
    const std::vector<std::string> records = records_of(options);
    if (is_standard_output(options.atlas))
        return report_error("an atlas cannot be written to standard output, '-'; expected a file name");
    if (!options.atlas.empty())
        if (Status writable = display::check_writable(options.atlas); !writable) return report_error(writable.error());
    if (records.empty())
        return report_error("no records to merge; expected their names, or --shards N for OUT.exr.shard-1-of-N ...");
    constexpr double patience = 10;  // seconds; the process of a shard takes its lock sooner
    if (options.wait)
        if (Status all = wait_for_files(records, shard_lock, patience); !all) return report_error(all.error());
    auto merged = merge_shards(records);
    if (!merged) return report_error(merged.error());
    merged->image.description.attributes["raylex/merge_command"] = shell_command(arguments);
    if (Status written = write_merged_image(options.output, *merged); !written) return report_error(written.error());
    int code = check_new_image(options.output);
    if (code == exit_bad_input) return code;
    if (!options.atlas.empty()) {
        const int of_atlas = merge_atlases(options.atlas, *merged);
        if (of_atlas == exit_bad_input) return of_atlas;
        code = std::max(code, of_atlas);
    } else if (merged->has_atlas) {
        print_note(
            "the shards have path atlases; --atlas FILE.atlas.exr, with the name used for the render, merges them");
    }
    if (merged->facts.invalid_samples > 0)
        print_warning(std::to_string(merged->facts.invalid_samples) +
                      " contributions or values were not finite or too large to sum; they are missing from beauty and "
                      "layers alike");
    const display::FrameBufferLayout& layout = merged->pixels->layout();
    const ShardFacts& facts = merged->facts;
    print_line(options.output + ": " + std::to_string(layout.width) + "x" + std::to_string(layout.height) + ", " +
               counted(merged->shards, "shard") + ", " + std::to_string(facts.range.total) + " samples per pixel, " +
               duration_text(facts.cpu_seconds) + " CPU in total" +
               (facts.guide_samples > 0
                    ? "; the guide learned from " + counted(facts.guide_samples, "other sample") + " of each pixel"
                    : std::string()) +
               (facts.guide_cpu_seconds > 0 ? " (" + duration_text(facts.guide_cpu_seconds) + " CPU)" : std::string()));
    return code;
}

}  // namespace

void add_merge_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "merge",
        "Merges the records of 'raylex render --shard' into the image, with the same bits as a single render.");
    auto options = std::make_shared<ImageMergeOptions>();
    command->add_option("RECORD", options->records, "records of all shards of a render, in any order")
        ->option_text("...");
    command->add_option("--shards", options->shards, "merges the records OUT.exr.shard-1-of-N to OUT.exr.shard-N-of-N")
        ->option_text("N")
        ->check(CLI::Range(1U, 1000000U));
    command->add_flag(
        "--wait", options->wait,
        "waits for shards that processes on this machine are rendering, and ten seconds for a process to begin");
    command->add_option("-o,--output", options->output, "image file")->required()->option_text("OUT.exr (required)");
    command
        ->add_option("--atlas", options->atlas,
                     "also merges the path atlases of the shards, FILE.shard-1-of-N to FILE.shard-N-of-N")
        ->option_text("FILE.atlas.exr");
    add_plugin_option(*command, options->plugins);
    command->footer(
        "The records are kept. A record of another build, seed, scene or setting is an error that names it. Duplicate "
        "or\nmissing samples are errors. Exit codes: 0 done; 1 a split does not hold; 2 bad input.");
    command->callback([options, &context] { context.exit_code = merge_records(*options, context.arguments); });
}

}  // namespace raylex::experiments
