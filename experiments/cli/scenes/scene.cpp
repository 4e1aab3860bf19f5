// raylex scene: describes, writes and checks scenes.
#include <filesystem>
#include <memory>

#include "experiments/cli/commands.h"
#include "experiments/cli/loading_line.h"
#include "experiments/cli/option_group.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/cli/scenes/scene_commands.h"
#include "experiments/inspect/scene_warnings.h"
#include "experiments/invariants/checking_process.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/program/tint.h"
#include "transport/files/input_file.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/import/pbrt/pbrt_writer.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

void print_warnings(const std::vector<Error>& warnings) {
    for (const Error& warning : warnings) print_warning(warning.to_string());
}

// --- write ---

struct WriteOptions {
    std::string input, output;
    std::vector<std::string> plugins;
};

int print_scene(const transport::SceneDescription& scene) {
    const transport::PbrtText text = transport::pbrt_text(scene);
    if (!text.meshes.empty())
        return report_error(
            counted(text.meshes.size(), "mesh", "meshes") +
            " of the scene came from files and are written to files beside the scene; expected a file name "
            "behind -o");
    for (const std::string& each : text.left_out) print_warning(each);
    const Status written = write_text("-", text.text);
    return written ? exit_holds : report_error(written.error());
}

int write_scene(const WriteOptions& options) {
    if (Status loaded = load_plugins(options.plugins); !loaded) return report_error(loaded.error());
    const auto scene = transport::import_pbrt(options.input);
    if (!scene) return report_error(scene.error());
    print_warnings(scene->warnings);
    if (is_standard_output(options.output)) return print_scene(*scene);
    std::error_code none;
    if (fs::equivalent(options.input, options.output, none))
        return report_error(
            error_at({options.output, 0, 0}, "this file is the input scene", "choose another file name"));
    const auto left_out = transport::write_pbrt(*scene, options.output);
    if (!left_out) return report_error(left_out.error());
    for (const std::string& each : *left_out) print_warning(each);
    return exit_holds;
}

void add_write_command(CLI::App& scene, CommandContext& context) {
    CLI::App* command = scene.add_subcommand("write", "Writes a scene as one resolved pbrt-v4 file.");
    auto options = std::make_shared<WriteOptions>();
    command->add_option("IN.pbrt", options->input, "the scene; its includes and imports are merged into the output")
        ->required();
    command
        ->add_option(
            "-o,--output", options->output,
            "output file; meshes from files are written to FILE.meshes/. -: standard output, only without such meshes")
        ->option_text("OUT.pbrt")
        ->required();
    add_plugin_option(*command, options->plugins);
    command->footer(
        "Includes, imports, attributes, names and transforms are resolved. Numbers have enough digits to be read back "
        "exactly,\nso the file renders the same bits. Images are referenced by absolute path.\n"
        "Exit codes: 0 written, 2 bad usage or input.");
    command->callback([options, &context] { context.exit_code = write_scene(*options); });
}

// --- check ---

struct SceneCheckOptions {
    std::string input;
    bool invariants = false;
    double timeout = 600;
    std::vector<std::string> plugins;
    InvariantOptions check;
};

const char* outcome_text(InvariantState outcome) {
    switch (outcome) {
        case InvariantState::holds:
            return "holds";
        case InvariantState::violated:
            return "VIOLATED";
        case InvariantState::skipped:
            break;
    }
    return "skipped";
}

std::string table_cell(std::string text, std::size_t width) {
    text.resize(std::max(text.size() + 1, width), ' ');
    return text;
}

void print_results(const std::vector<InvariantResult>& results) {
    print_line(table_cell("invariant", 18) + table_cell("measured", 12) + table_cell("bound", 12) +
               table_cell("verdict", 10));
    for (const InvariantResult& result : results) {
        const bool skipped = result.outcome == InvariantState::skipped;
        print_line(table_cell(result.invariant, 18) + table_cell(skipped ? "-" : number_text(result.measured), 12) +
                   table_cell(skipped ? "-" : number_text(result.bound), 12) +
                   table_cell(outcome_text(result.outcome), 10) + result.note);
    }
}

int check_scene(const SceneCheckOptions& options) {
    if (Status loaded = load_plugins(options.plugins); !loaded) return report_error(loaded.error());
    if (!options.invariants) {
        LoadingLine loading;
        const auto scene = transport::import_pbrt(
            options.input,
            {.missing = transport::MissingFiles::placeholders, .threads = 0, .progress = loading.progress()});
        const auto built = scene ? transport::BuiltScene::build(*scene, {}, loading.progress()) : scene.error();
        loading.finish();
        if (!scene) return report_error(scene.error());
        print_warnings(scene->warnings);
        if (!built) return report_error(built.error());
        print_warnings((*built)->warnings);
        if (const Status can = transport::check_render(**built, {}); !can) return report_error(can.error());
        const std::vector<Error> warnings = scene_warnings(*scene, **built);
        for (const Error& warning : warnings) print_line(warning.to_string());
        const std::size_t objects = scene->objects.size();
        std::size_t shapes = scene->shapes.size();
        for (const transport::SceneObject& object : scene->objects) shapes += object.shapes.size();
        print_line(options.input + ": " + counted(shapes, "shape") + ", " + counted(objects, "object") + ", " +
                   counted(scene->instances.size(), "instance") + ", " +
                   counted(scene->lights.size() + scene->area_lights.size(), "light") + ", " +
                   counted(scene->warnings.size() + (*built)->warnings.size(), "warning") + ", " +
                   counted(warnings.size(), "likely mistake") +
                   (scene->placeholders.empty()
                        ? ""
                        : ", " + counted(scene->placeholders.size(), "file") + " that cannot be found"));
        return warnings.empty() && scene->placeholders.empty() ? exit_holds : exit_does_not_hold;
    }
    const auto text = transport::read_file(options.input, NamedBy::file, "a pbrt-v4 scene");
    if (!text) return report_error(text.error());
    const auto report = CheckingProcess(options.input, options.timeout).check(*text, options.check, &interrupt_flag());
    if (!report) return report_error(report.error());
    if (interrupt_flag().load()) return exit_interrupted;
    if (!report->refused.empty()) return report_error("the scene has an error: " + report->refused);
    print_results(report->results);
    return report->holds() ? exit_holds : exit_does_not_hold;
}

std::string invariant_list() {
    std::string list;
    for (const InvariantInfo& info : invariants())
        list += "  " + table_cell(std::string(info.name), 18) + std::string(info.help) + "\n";
    return list;
}

void add_check_command(CLI::App& scene, CommandContext& context) {
    CLI::App* command = scene.add_subcommand(
        "check", "Reports likely mistakes in a scene. With --invariants it checks the images of the scene instead.");
    auto options = std::make_shared<SceneCheckOptions>();
    command->add_option("SCENE.pbrt", options->input, "the scene")->required();
    const OptionGroup group(*command, "Options");
    auto* invariants =
        group.add_flag("--invariants", options->invariants,
                       "renders small images of the scene and of variants of it, and prints a table of invariants");
    group.add_repeated("--only", options->check.only, "NAME", "checks only this invariant (listed below)")
        ->needs(invariants);
    group.add("--seed", options->check.seed, "N",
              "seed of the samples and of the expressions that split the light; default 0");
    group.add("--pixels", options->check.most_pixels, "N", "maximum number of pixels of an image; default 64");
    group.add("--samples", options->check.most_samples, "N",
              "maximum number of samples per pixel where bits are compared; default 4");
    group.add("--mean-samples", options->check.samples_of_means, "N",
              "samples per pixel where means are compared; default 64");
    group.add("--replicates", options->check.replicates, "N",
              "renders per mean; default 8. A failure is confirmed with four times as many");
    group.add("--timeout", options->timeout, "S", "seconds after which the scene counts as hanging; default 600");
    add_plugin_option(*command, options->plugins);
    command->footer(
        "Without --invariants: reports useless normals and texture coordinates, lights without power,\nand unused "
        "definitions, each with its line in the file.\n"
        "Invariants:\n" +
        invariant_list() +
        "Means are compared by Student's t test at a level of 1e-9: in a million comparisons, a false alarm has "
        "probability 0.001.\n"
        "Exit codes: 0 no failure and no likely mistake, 1 a failure or likely mistake, 2 bad usage or input.");
    command->callback([options, &context] { context.exit_code = check_scene(*options); });
}

}  // namespace

void add_scene_command(CLI::App& app, CommandContext& context) {
    CLI::App* scene =
        app.add_subcommand("scene", "Prints what scenes contain, checks scenes and their images, writes scenes.");
    scene->require_subcommand(1);
    add_scene_info_command(*scene, context);
    add_check_command(*scene, context);
    add_write_command(*scene, context);
}

}  // namespace raylex::experiments
