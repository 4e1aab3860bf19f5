// raylex denoise: denoises the layers of light of an image so that they still sum.
#include <array>
#include <memory>
#include <string>

#include "display/output/denoise/denoised_image.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/image_commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/report/denoised_text.h"

namespace raylex::experiments {
namespace {

struct DenoiseCommand {
    std::string image, output;
    display::DenoiseOptions options;
};

int run_denoise(const DenoiseCommand& command) {
    const std::array inputs{command.image, command.options.second};
    if (Status good = check_new_exr(command.output, inputs); !good) return report_error(good.error());
    const auto denoised = display::denoise_exr(command.image, command.output, command.options);
    if (!denoised) return report_error(denoised.error());
    for (const std::string& line : denoised_text(*denoised)) print_line(line);
    const int code = check_new_image(command.output);
    if (code != exit_bad_input) print_line(command.output + ": " + counted(denoised->layers.size(), "denoised layer"));
    return code;
}

}  // namespace

void add_denoise_command(CLI::App& app, CommandContext& context) {
    CLI::App* command =
        app.add_subcommand("denoise", "Denoises the beauty and all layers of an image so that they still sum.");
    auto options = std::make_shared<DenoiseCommand>();
    command->add_option("IMAGE.exr", options->image, "the image, from raylex render --denoise or another renderer")
        ->required()
        ->option_text("(required)");
    command->add_option("-o,--output", options->output, "denoised image")->option_text("OUT.exr")->required();
    command
        ->add_option("--second", options->options.second,
                     "a second render of the same image with other random numbers: the mean of both is denoised, and "
                     "their difference is the noise")
        ->option_text("OTHER.exr");
    command->add_flag("--keep-noisy", options->options.keep_noisy,
                      "keeps noisy layers as NAME_noisy, and their statistics");
    command->add_option("--threads", options->options.threads, "number of threads; default 0: all cores")
        ->option_text("N")
        ->check(CLI::Range(0, 4096));
    command->footer(
        "A layer is denoised if its noise is known: from NAME_mse (the variance of its pixels), from NAME_even and "
        "NAME_odd\n(two halves of its samples), or by --second. Albedo and normals guide the filter. Alpha, AOVs, "
        "mattes, "
        "ids and deep\nparts are copied. NAME_error is the estimated standard error of a pixel.\n"
        "Exit codes: 0 success and all partitions sum, 1 a partition does not hold, 2 bad usage or input.");
    command->callback([options, &context] { context.exit_code = run_denoise(*options); });
}

}  // namespace raylex::experiments
