// raylex mix: scales the light groups of an image and recomputes its beauty.
#include <cmath>
#include <filesystem>
#include <memory>

#include "display/output/reader/exr_layers.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/image_commands.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/mix/image_mix.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"

namespace raylex::experiments {
namespace {

struct MixOptions {
    std::string image, output, file;
    std::vector<std::string> factors;
};

Result<std::vector<ColorFactor>> factors_of(const MixOptions& options) {
    Mix mix;
    if (!options.file.empty())
        if (Status read = read_mix(options.file, mix); !read) return read.error();
    if (!mix.colors.empty())
        return error_at(mix.colors.front().where,
                        "'" + mix.colors.front().name +
                            "' is a colour of an object, and an image has no light by objects; expected only [light]",
                        "an atlas has it: raylex ask FILE.atlas.exr --mix " + options.file);
    for (const std::string& text : options.factors) {
        auto factor = parse_factor(text, "mix");
        if (!factor) return factor.error();
        mix.lights.push_back(*std::move(factor));
    }
    if (mix.lights.empty())
        return error_at({"mix", 0, 0}, "no factors; expected LAYER=FACTOR, such as light_key=1.5, or --mix FILE.toml");
    return mix.lights;
}

int mix(const MixOptions& options, const CommandContext& context) {
    if (std::filesystem::path(options.output).extension() != ".exr")
        return report_error("the output '" + options.output + "' does not end in .exr; expected an OpenEXR file name");
    std::error_code failed;
    if (options.image == options.output || std::filesystem::equivalent(options.image, options.output, failed))
        return report_error("'" + options.output + "' is the input and would be overwritten; expected another file");
    const auto factors = factors_of(options);
    if (!factors) return report_error(factors.error());
    const auto mixed = mix_image(options.image, options.output, *factors, shell_command(context.arguments));
    if (!mixed) return report_error(mixed.error());
    if (!mixed->is_proved)
        print_warning("the header declares no partition with " + display::list_names(mixed->scaled) +
                      "; the layers are taken for disjoint parts of the beauty");
    for (const std::string& each : mixed->left_out)
        print_warning(each + " is left out: its light does not follow the factors");
    constexpr double visible = 1e-4;
    if (mixed->is_whole && std::abs(mixed->unassigned) > visible)
        print_note(number_text(100 * mixed->unassigned) + " % of the beauty is in no layer; it is kept as it is");
    const int code = check_new_image(options.output);
    if (code != exit_bad_input)
        print_line(options.output + ": scaled " + display::list_names(mixed->scaled) +
                   (mixed->kept.empty() ? "" : "; kept " + display::list_names(mixed->kept)));
    return code;
}

}  // namespace

void add_mix_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "mix", "Scales the light groups of an image, of any renderer, and recomputes the beauty from them.");
    auto options = std::make_shared<MixOptions>();
    command->add_option("IMAGE.exr", options->image, "the image, with a layer for each light group")
        ->required()
        ->option_text("(required)");
    command
        ->add_option("FACTOR", options->factors,
                     "LAYER=FACTOR: a layer, or the name of its light group, and its factor: 1.5; 1,0.8,0.6 for red, "
                     "green and blue; +1stop; 0 removes the light")
        ->option_text("...");
    command->add_option("--mix", options->file, "more factors from the table [light] of a TOML file")
        ->option_text("FILE.toml");
    command->add_option("-o,--output", options->output, "the mixed image")
        ->required()
        ->option_text("OUT.exr (required)");
    command->footer(
        "Light without a layer is kept. Layers of light that cannot follow the factors are left out and named; all "
        "other\nlayers keep their bits. Example: raylex mix shot.exr light_key=+1stop light_lamp=1,0.8,0.6 -o "
        "warm.exr\nExit codes: 0 done; 1 a partition does not hold; 2 bad usage or input.");
    command->callback([options, &context] { context.exit_code = mix(*options, context); });
}

}  // namespace raylex::experiments
