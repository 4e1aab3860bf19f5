// raylex verify: do the layers of an image sum to what they split?
#include <memory>

#include "display/output/exr_reader.h"
#include "display/output/split_check.h"
#include "experiments/cli/command_line.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/console.h"
#include "experiments/cli/judge.h"

namespace raylex::experiments {
namespace {

struct VerifyOptions {
    std::vector<std::string> files, globs;
    std::string of;
};

/// Prints a verdict; a failure leaves its heat map. Returns whether it holds.
bool print_verdict(const display::SplitVerdict& verdict, const display::ExrImage& image) {
    print_line(image.path + ": " + verdict_text(verdict));
    if (!verdict.holds) print_line("  " + write_residual_map(verdict, image));
    return verdict.holds;
}

void note_incomplete(const display::ExrImage& image) {
    if (image.attributes.contains("raylex/incomplete"))
        print_line(image.path + ": the render was interrupted; this image is incomplete");
}

std::string layer_list(const display::ExrImage& image) {
    std::string list;
    for (const display::ImageLayer& layer : image.layers)
        list += (list.empty() ? "" : ", ") + (layer.name.empty() ? std::string("beauty") : layer.name);
    return list;
}

int verify_sum(const VerifyOptions& options) {
    auto image =
        options.files.size() == 1 ? display::read_exr(options.files.front()) : display::read_exr_set(options.files);
    if (!image) return report_error(image.error());
    auto verdict = display::check_split(*image, options.of, options.globs);
    if (!verdict) return report_error(verdict.error());
    note_incomplete(*image);
    return print_verdict(*verdict, *image) ? exit_holds : exit_does_not_hold;
}

int verify_declared(const VerifyOptions& options) {
    bool all_hold = true;
    std::string without;
    for (const std::string& file : options.files) {
        auto image = display::read_exr(file);
        if (!image) return report_error(image.error());
        if (image->partitions.empty()) {
            if (without.empty())
                without = file +
                          ": no partition is declared in the header, so there is nothing to judge. Say which layers "
                          "must sum to which: raylex verify " +
                          file +
                          " --of beauty --sum 'diffuse_*,specular_*,emission'. "
                          "The layers are: " +
                          layer_list(*image);
            continue;
        }
        auto verdicts = display::check_declared_splits(*image);
        if (!verdicts) return report_error(verdicts.error());
        note_incomplete(*image);
        for (const display::SplitVerdict& verdict : *verdicts) all_hold = print_verdict(verdict, *image) && all_hold;
    }
    if (!without.empty()) return report_error(without);
    return all_hold ? exit_holds : exit_does_not_hold;
}

}  // namespace

void add_verify_command(CLI::App& app, CommandContext& context) {
    CLI::App* command =
        app.add_subcommand("verify", "Checks pixel by pixel that the layers of an image sum to what they split.");
    auto options = std::make_shared<VerifyOptions>();
    command
        ->add_option("FILE.exr", options->files,
                     "images of any renderer; with --sum, several files are the layers of one image")
        ->required()
        ->option_text("...");
    command->add_option("--of", options->of, "the layer that is split; with --sum, default beauty")
        ->option_text("LAYER");
    command->add_option("--sum", options->globs, "the layers that must sum to it, with * and ?")
        ->option_text("GLOB,...")
        ->delimiter(',')
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->footer(
        "Without --sum every partition declared in the header is judged. The bound on |sum - of| is the rounding of "
        "the stored\n"
        "type (float 2^-23, half 2^-10) times the sum of |layers| + |of|. A failure writes a residual heat map beside "
        "the image.\n"
        "Exit codes: 0 holds, 1 does not hold, 2 bad usage or input.");
    command->callback([options, &context] {
        if (!options->of.empty() && options->globs.empty()) {
            context.exit_code =
                report_error("--of " + options->of +
                             " needs --sum with the layers that must sum to it, such as --sum 'diffuse_*,emission'");
            return;
        }
        context.exit_code = options->globs.empty() ? verify_declared(*options) : verify_sum(*options);
    });
}

}  // namespace raylex::experiments
