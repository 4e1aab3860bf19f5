// raylex mix: scales the light groups of an image and recomputes its beauty.
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

int mix(const MixOptions& options, const CommandContext& context) {
    if (Status good = check_new_exr(options.output); !good) return report_error(good.error());
    Mix factors;
    if (!options.file.empty())
        if (Status read = read_mix(options.file, factors); !read) return report_error(read.error());
    if (Status added = add_factors(options.factors, "mix", factors.lights); !added) return report_error(added.error());
    const auto mixed = mix_image(options.image, options.output, factors, shell_command(context.arguments));
    if (!mixed) return report_error(mixed.error());
    for (const std::string& note : mix_notes(*mixed)) print_warning(note);
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
