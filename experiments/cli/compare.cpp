// raylex compare: one number that says how far an image is from a reference.
#include <memory>

#include "display/output/exr_reader.h"
#include "display/output/split_check.h"
#include "experiments/cli/command_line.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/console.h"

namespace raylex::experiments {
namespace {

struct CompareOptions {
    std::string image, reference, metric = "relmse", layer = "beauty", channel;
};

display::CompareMetric metric_of(const std::string& name) {
    if (name == "mse") return display::CompareMetric::mse;
    if (name == "mae") return display::CompareMetric::mae;
    if (name == "mape") return display::CompareMetric::mape;
    if (name == "mean-ratio") return display::CompareMetric::mean_ratio;
    return display::CompareMetric::relmse;
}

int run_compare(const CompareOptions& options) {
    auto image = display::read_exr(options.image);
    if (!image) return report_error(image.error());
    auto reference = display::read_exr(options.reference);
    if (!reference) return report_error(reference.error());
    const char component = options.channel.empty() ? 'A' : options.channel.front();
    auto value = display::compare(*image, *reference, metric_of(options.metric), options.layer, component);
    if (!value) return report_error(value.error());
    print_line(number_text(*value, 9));
    return exit_holds;
}

std::string formulas() {
    std::string text = "Formulas, a the image and b the reference:";
    for (const char* name : {"relmse", "mse", "mae", "mape", "mean-ratio"})
        text += "\n  " + std::string(name) + std::string(12 - std::string(name).size(), ' ') +
                display::formula(metric_of(name));
    return text + "\nPrimaries are converted when the files' chromaticities differ.";
}

}  // namespace

void add_compare_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("compare", "Prints one number: how far A.exr is from the reference B.exr.");
    auto options = std::make_shared<CompareOptions>();
    command->add_option("A.exr", options->image, "the image")->required()->option_text("(required)");
    command->add_option("B.exr", options->reference, "the reference")->required()->option_text("(required)");
    command->add_option("--metric", options->metric, "relmse (default), mse, mae, mape or mean-ratio")
        ->option_text("NAME")
        ->check(CLI::IsMember({"relmse", "mse", "mae", "mape", "mean-ratio"}));
    command->add_option("--layer", options->layer, "layer to compare; default beauty")->option_text("NAME");
    command->add_option("--channel", options->channel, "R, G, B or Y (luminance); default: the mean over R, G and B")
        ->option_text("R|G|B|Y")
        ->check(CLI::IsMember({"R", "G", "B", "Y"}));
    command->footer(formulas());
    command->callback([options, &context] { context.exit_code = run_compare(*options); });
}

}  // namespace raylex::experiments
