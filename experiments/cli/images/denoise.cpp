// raylex denoise: denoises the layers of light of an image so that they still sum.
#include <filesystem>
#include <memory>
#include <string>

#include "display/output/atomic_file.h"
#include "display/output/denoise/denoised_image.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
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
    namespace fs = std::filesystem;
    if (fs::path(command.output).extension() != ".exr")
        return report_error("the output '" + command.output + "' does not end in .exr; expected an OpenEXR file name");
    for (const std::string& input : {command.image, command.options.second}) {
        std::error_code failed;
        if (!input.empty() && (input == command.output || fs::equivalent(input, command.output, failed)))
            return report_error("'" + input + "' is an input and would be overwritten; expected a different file");
    }
    if (Status writable = display::check_writable(command.output); !writable) return report_error(writable.error());
    const auto denoised = display::denoise_exr(command.image, command.output, command.options);
    if (!denoised) return report_error(denoised.error());
    for (const std::string& line : denoised_text(*denoised)) print_line(line);
    const auto file = display::ExrBands::open(command.output);
    if (!file) return report_error(file.error());
    const auto results = display::check_declared_splits(*file);
    if (!results) return report_error(results.error());
    const bool hold = print_results_of_new(*results, file->image());
    print_line(command.output + ": " + std::to_string(file->image().width) + "x" +
               std::to_string(file->image().height) + ", " + counted(denoised->layers.size(), "denoised layer") +
               " of " + counted(file->image().layers.size(), "layer"));
    return hold ? exit_holds : exit_does_not_hold;
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
