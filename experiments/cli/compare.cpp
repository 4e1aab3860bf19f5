// raylex compare: one number that says how far an image is from a reference.
#include <memory>
#include <string>
#include <vector>

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

std::vector<std::string> metric_names() {
    std::vector<std::string> names;
    for (const display::ErrorMetricInfo& each : display::error_metrics()) names.emplace_back(each.name);
    return names;
}

int run_compare(const CompareOptions& options) {
    auto image = display::read_exr(options.image);
    if (!image) return report_error(image.error());
    auto reference = display::read_exr(options.reference);
    if (!reference) return report_error(reference.error());
    const char component = options.channel.empty() ? 'A' : options.channel.front();
    const display::ErrorMetric metric = display::find_error_metric(options.metric)->metric;
    auto value = display::compare(*image, *reference, metric, options.layer, component);
    if (!value) return report_error(value.error());
    print_line(number_text(*value, 9));
    return exit_holds;
}

std::string formulas() {
    std::string text = "Formulas, a the image and b the reference:";
    for (const display::ErrorMetricInfo& each : display::error_metrics())
        text += "\n  " + std::string(each.name) + std::string(21 - std::string(each.name).size(), ' ') + each.formula;
    return text +
           "\nPrimaries are converted when the files' chromaticities differ. A ratio to a black reference has no\n"
           "value: that is an error, code 2.";
}

}  // namespace

void add_compare_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("compare", "Prints one number: how far A.exr is from the reference B.exr.");
    auto options = std::make_shared<CompareOptions>();
    command->add_option("A.exr", options->image, "the image")->required()->option_text("(required)");
    command->add_option("B.exr", options->reference, "the reference")->required()->option_text("(required)");
    command->add_option("--metric", options->metric, "the metric, one of those below; default relmse")
        ->option_text("NAME")
        ->check(CLI::IsMember(metric_names()));
    command->add_option("--layer", options->layer, "layer to compare; default beauty")->option_text("NAME");
    command->add_option("--channel", options->channel, "R, G, B or Y (luminance); default: the mean over R, G and B")
        ->option_text("R|G|B|Y")
        ->check(CLI::IsMember({"R", "G", "B", "Y"}));
    command->footer(formulas());
    command->callback([options, &context] { context.exit_code = run_compare(*options); });
}

}  // namespace raylex::experiments
