// raylex scene info: prints the contents of a scene, and renders a small picture of it.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "display/output/atomic_file.h"
#include "display/output/color/color_manager.h"
#include "experiments/cli/loading_line.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/cli/scenes/scene_commands.h"
#include "experiments/inspect/scene_facts.h"
#include "experiments/job/rendering/color_setup.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "transport/import/pbrt/pbrt_importer.h"

namespace raylex::experiments {
namespace {

struct SceneInfoOptions {
    std::string input, json, picture;
    std::vector<std::string> plugins;
    int picture_side = 400;
    std::uint64_t picture_samples = 16;
    bool without_build = false;
};

/// Returns a picture size with the image's aspect ratio and a longer side of at most `side` pixels.
std::array<int, 2> picture_size(const SceneFacts& facts, int side) {
    const double scale = std::min(1.0, double(side) / std::max({facts.width, facts.height, 1}));
    const auto scaled = [scale](int size) { return std::max(1, static_cast<int>(size * scale + 0.5)); };
    return {scaled(facts.width), scaled(facts.height)};
}

Status write_picture(const transport::BuiltScene& scene, const transport::SceneDescription& description,
                     const SceneFacts& facts, const SceneInfoOptions& options) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = options.picture_samples;
    settings.film.resolution = picture_size(facts, options.picture_side);
    auto output = render(scene, settings, {}, &interrupt_flag());
    if (!output) return output.error();
    const std::vector<double> pixels =
        output->frame_buffer.resolve(output->beauty, {0, 0, output->view.width, output->view.height});
    const std::vector<float> rgb(pixels.begin(), pixels.end());
    const auto color = display::ColorManager::open();
    if (!color) return color.error();
    const auto shown = color->to_display(rgb, chromaticities_of(description.color.scene_space), {}, {});
    if (!shown) return shown.error();
    return display::write_png(options.picture, output->view.width, output->view.height, *shown);
}

int tell_of(const SceneInfoOptions& options) {
    take_standard_output_for(options.json);
    if (Status loaded = load_plugins(options.plugins); !loaded) return report_error(loaded.error());
    const auto begin = std::chrono::steady_clock::now();
    LoadingLine loading;
    const auto scene = transport::import_pbrt(options.input, {.progress = loading.progress()});
    if (!scene) return loading.finish(), report_error(scene.error());
    SceneFacts facts = scene_facts(*scene);
    facts.read_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::shared_ptr<const transport::BuiltScene> built;
    if (!options.without_build) {
        auto made = transport::BuiltScene::build(*scene, {}, loading.progress());
        if (!made) return loading.finish(), report_error(made.error());
        built = *made;
        add_built_facts(*built, facts);
    }
    if (built)
        if (const Status can = transport::check_render(*built, {}); !can)
            facts.warnings.push_back("cannot be rendered: " + can.error().to_string());
    loading.finish();
    for (const std::string& line : lines_of(facts)) print_line(line);
    for (const std::string& warning : facts.warnings) print_warning(warning);
    if (!options.json.empty()) {
        Status written = write_text(options.json, json_text(json_of(facts), 2) + "\n");
        if (!written) return report_error(written.error());
    }
    if (!options.picture.empty()) {
        if (Status written = write_picture(*built, *scene, facts, options); !written)
            return report_error(written.error());
        if (interrupt_flag().load()) return exit_interrupted;
        print_line("  picture       " + options.picture);
    }
    return exit_holds;
}

}  // namespace

void add_scene_info_command(CLI::App& scene, CommandContext& context) {
    CLI::App* command =
        scene.add_subcommand("info", "Prints the contents of a scene: counts, bounds, memory, effects.");
    auto options = std::make_shared<SceneInfoOptions>();
    command->add_option("SCENE.pbrt", options->input, "the scene")->required();
    command
        ->add_option("--json", options->json,
                     "also writes the contents as JSON; -: to standard output, and the text to standard error")
        ->option_text("FILE");
    auto* picture =
        command->add_option("--picture", options->picture, "writes a small picture from the scene's camera as PNG")
            ->option_text("FILE.png")
            ->check([](const std::string& name) {
                return std::filesystem::path(name).extension() == ".png"
                           ? std::string()
                           : "picture '" + name + "' does not end in .png; expected a PNG file name";
            });
    command->add_option("--picture-side", options->picture_side, "longer side of the picture in pixels; default 400")
        ->option_text("N")
        ->check(CLI::Range(1, 8192))
        ->needs(picture);
    command->add_option("--picture-samples", options->picture_samples, "samples per pixel of the picture; default 16")
        ->option_text("N")
        ->check(CLI::Range(1, 1 << 20))
        ->needs(picture);
    command
        ->add_flag("--no-build", options->without_build,
                   "reads only the scene files; builds no acceleration structure and reads no images, so the bounds "
                   "are missing")
        ->excludes(picture);
    add_plugin_option(*command, options->plugins);
    command->footer(
        "Primitives are counted as in the file: displaced meshes before subdivision, and an object once, however many "
        "instances it has.\n"
        "Exit codes: 0 success, 2 bad usage or input, 130 after Ctrl-C.");
    command->callback([options, &context] { context.exit_code = tell_of(*options); });
}

}  // namespace raylex::experiments
