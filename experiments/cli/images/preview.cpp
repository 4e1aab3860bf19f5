// raylex preview: shows a layer of any OpenEXR file as a PNG. raylex ocio: lists the values of --display, --view and
// more.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "display/output/atomic_file.h"
#include "display/output/color/color_manager.h"
#include "display/output/color/color_names.h"
#include "display/output/reader/exr_reader.h"
#include "experiments/cli/image_commands.h"
#include "experiments/job/output_requests.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/report/preview.h"

namespace raylex::experiments {
namespace {

struct PreviewOptions {
    std::string image, output, layer, ocio;
    bool named = false;  ///< whether -o was given
    PictureOptions picture;
};

std::string shown_name(const display::ImageLayer& layer) {
    return layer.name.empty() ? "beauty" : layer.name;
}

int run_preview(PreviewOptions options) {
    namespace fs = std::filesystem;
    if (!options.named) options.output = fs::path(options.image).stem().string() + ".png";
    if (fs::path(options.output).extension() != ".png")
        return report_error("the preview '" + options.output + "' does not end in .png; expected a PNG file name");
    auto color = display::ColorManager::open(options.ocio);
    if (!color) return report_error(color.error());
    if (Status known = display::check_view(*color, options.picture.display, options.picture.view); !known)
        return report_error(known.error());
    auto image = display::read_exr(options.image);
    if (!image) return report_error(image.error());
    auto layer = shown_layer(*image, options.layer);
    if (!layer) return report_error(layer.error());
    auto picture = picture_of(*image, **layer, *color, options.picture);
    if (!picture) return report_error(picture.error());
    Status written = display::write_png(options.output, picture->width, picture->height, picture->rgb);
    if (!written) return report_error(written.error());
    std::string line = options.output + ": " + std::to_string(picture->width) + "x" + std::to_string(picture->height) +
                       ", " + shown_name(**layer);
    if (const LayerLook look = look_of(**layer); look != LayerLook::light) {
        line += std::string(", ") + describe(look);
    } else {
        const std::string& display = options.picture.display;
        line += " through " + (options.picture.view.empty() ? color->default_view(display) : options.picture.view) +
                " of " + (display.empty() ? color->default_display() : display);
        if (options.picture.exposure != 0) line += ", exposure " + number_text(options.picture.exposure) + " stops";
    }
    print_line(line);
    return exit_holds;
}

int run_ocio(const std::string& config) {
    auto color = display::ColorManager::open(config);
    if (!color) return report_error(color.error());
    auto names = display::config_names(config);
    if (!names) return report_error(names.error());
    print_line("config: " + color->description());
    const auto mark = [](bool is_default) { return std::string(is_default ? "  (default)" : ""); };
    print_line("displays and their views (--display, --view):");
    for (const std::string& display : color->displays()) {
        print_line("  " + display + mark(display == color->default_display()));
        for (const std::string& view : color->views(display))
            print_line("    " + view + mark(view == color->default_view(display)));
    }
    print_line("spaces (--rendering-space accepts the scene-linear ones):");
    for (const display::ColorSpaceEntry& each : names->spaces)
        print_line("  " + each.name + (each.scene_linear ? "  (scene-linear)" : each.data ? "  (data)" : ""));
    print_line(names->looks.empty() ? "looks: none" : "looks:");
    for (const std::string& look : names->looks) print_line("  " + look);
    for (const std::string& warning : color->warnings()) print_warning(warning);
    return exit_holds;
}

CLI::Option* add_ocio_option(CLI::App& command, std::string& config) {
    return command.add_option("--ocio", config, "OpenColorIO config; default: $OCIO, else raylex's own")
        ->option_text("FILE");
}

}  // namespace

void add_preview_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("preview", "Shows a layer of any OpenEXR file as a PNG.");
    auto options = std::make_shared<PreviewOptions>();
    command->add_option("FILE.exr", options->image, "the image, from raylex or another program")
        ->required()
        ->option_text("(required)");
    CLI::Option* output =
        command
            ->add_option("-o,--output", options->output,
                         "picture to write; default: the name of the image with .png, in the current folder")
            ->option_text("OUT.png");
    command
        ->add_option("--layer", options->layer,
                     "layer to show; default: the beauty under any name, else the first layer of light")
        ->option_text("NAME");
    command
        ->add_option("--display", options->picture.display,
                     "display in the colour config; default: the config's default")
        ->option_text("NAME");
    command->add_option("--view", options->picture.view, "view of that display; default: the config's default")
        ->option_text("NAME");
    command->add_option("--exposure", options->picture.exposure, "exposure in stops; default 0")
        ->option_text("STOPS")
        ->check(CLI::Range(-largest_exposure, largest_exposure));
    command
        ->add_option("--size", options->picture.largest_side, "largest side in pixels; default: the size of the image")
        ->option_text("N")
        ->check(CLI::Range(1, 65536));
    add_ocio_option(*command, options->ocio);
    command->footer(
        "Light is shown through the display's view. Normals, positions, depths, ids and single values are shown in "
        "false\ncolours, and the scale is printed. 'raylex ocio' lists displays and views.");
    command->callback([options, output, &context] {
        options->named = output->count() > 0;
        context.exit_code = run_preview(*options);
    });
}

void add_ocio_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("ocio", "Lists the displays, views, spaces and looks of the colour config.");
    auto config = std::make_shared<std::string>();
    add_ocio_option(*command, *config);
    command->callback([config, &context] { context.exit_code = run_ocio(*config); });
}

}  // namespace raylex::experiments
