// raylex compare: prints the error of an image against a reference, by one metric or all, and shows where it is.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "display/output/atomic_file.h"
#include "display/output/comparison/comparison.h"
#include "display/output/reader/exr_reader.h"
#include "display/services/parameters.h"
#include "experiments/cli/commands.h"
#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"

namespace raylex::experiments {
namespace {

struct CompareOptions {
    std::string image, reference, metric = "relmse", layer = "beauty", channel;
    std::string output;
    bool json = false, writes = false;

    [[nodiscard]] char component() const { return channel.empty() ? 'A' : channel.front(); }
};

/// Returns the metrics that `name` selects, or an Error for an unknown name.
Result<std::vector<display::AnyMetric>> chosen_metrics(const std::string& name) {
    if (name == "all") return display::all_metrics();
    auto metric = display::require_metric(name, {"--metric", 0, 0}, {"all"});
    if (!metric) return metric.error();
    return std::vector{*std::move(metric)};
}

struct Measured {
    std::string name;
    Result<double> value;
};

Json json_of(const CompareOptions& options, const std::vector<Measured>& measured) {
    Json json{{"image", options.image}, {"reference", options.reference}, {"layer", options.layer}};
    json["channel"] = options.channel.empty() ? Json() : Json(options.channel);
    Json metrics = Json::object(), reasons = Json::object();
    for (const Measured& each : measured) {
        const bool number = each.value && std::isfinite(*each.value);
        metrics[each.name] = number ? Json(*each.value) : Json();
        if (!number) reasons[each.name] = each.value ? number_text(*each.value) : each.value.error().message;
    }
    json["metrics"] = std::move(metrics);
    if (!reasons.empty()) json["without_value"] = std::move(reasons);
    return json;
}

void print_table(const std::vector<Measured>& measured) {
    std::size_t width = 0;
    for (const Measured& each : measured) width = std::max(width, each.name.size());
    for (const Measured& each : measured)
        print_line(each.name + std::string(width + 2 - each.name.size(), ' ') +
                   (each.value ? number_text(*each.value, 9) : "-  (" + each.value.error().message + ")"));
}

/// Returns the end of the error image's colour scale: 1 for a fraction; otherwise the value that 99 % of the pixels
/// stay below, so that a few bright pixels leave the rest visible.
double end_of_scale(const display::AnyMetric& metric, const std::vector<double>& map) {
    if (metric.of_image) return 1;
    std::vector<double> finite;
    std::copy_if(map.begin(), map.end(), std::back_inserter(finite), [](double each) { return std::isfinite(each); });
    if (finite.empty()) return 0;
    const auto place = finite.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(finite.size() - 1));
    std::nth_element(finite.begin(), place, finite.end());
    return *place > 0 ? *place : *std::max_element(finite.begin(), finite.end());
}

Status write_errors(const CompareOptions& options, const display::AnyMetric& metric, const display::LayerPair& pair) {
    auto errors = pair.errors(metric, options.component());
    if (!errors) return errors.error();
    const std::vector<double>& map = errors->map;
    const auto largest = std::max_element(map.begin(), map.end());
    const auto place = static_cast<int>(largest - map.begin());
    const std::string at = number_text(*largest) + " at pixel (" + std::to_string(place % pair.width()) + ", " +
                           std::to_string(place / pair.width()) + ")";
    const std::string what = metric.name == "ssim" ? "1 - ssim" : metric.name;
    if (std::filesystem::path(options.output).extension() == ".png") {
        const double most = end_of_scale(metric, map);
        Status written = display::write_error_png(options.output, map, pair.width(), pair.height(), most);
        if (!written) return written;
        print_note(options.output + ": " + what +
                   " of each pixel: black 0, then blue, violet and red up to pale yellow " + number_text(most) +
                   " and above; largest " + at);
        return written;
    }
    Status written = display::write_error_exr(options.output, map, pair.width(), pair.height(),
                                              {{"raylex/metric", what},
                                               {"raylex/formula", metric.formula},
                                               {"raylex/image", options.image},
                                               {"raylex/reference", options.reference},
                                               {"raylex/layer", options.layer}});
    if (written) print_note(options.output + ": " + what + " of each pixel as channel 'error'; largest " + at);
    return written;
}

Status check_output(const CompareOptions& options) {
    if (!options.writes) return success();
    const std::string extension = std::filesystem::path(options.output).extension().string();
    if (extension != ".exr" && extension != ".png")
        return error_at({"-o", 0, 0},
                        "the error image '" + options.output + "' does not end in .exr or .png; expected one of these");
    if (options.metric == "all")
        return error_at({"-o", 0, 0}, "an error image shows one metric; expected --metric NAME as well");
    for (const std::string& input : {options.image, options.reference}) {
        std::error_code failed;
        if (std::filesystem::equivalent(input, options.output, failed))
            return error_at({"-o", 0, 0},
                            "'" + options.output + "' is one of the compared images; expected a different file");
    }
    return display::check_writable(options.output);
}

/// Prints a note for a crop. Its missing pixels count as black.
void note_data_window(const display::ExrImage& image) {
    if (!image.data_window) return;
    const display::PixelRegion& data = *image.data_window;
    print_note(image.path + ": the file has pixels only in " + std::to_string(data.x0) + "," + std::to_string(data.y0) +
               "," + std::to_string(data.x1) + "," + std::to_string(data.y1) + "; all others count as black");
}

int run_compare(const CompareOptions& options) {
    auto metrics = chosen_metrics(options.metric);
    if (!metrics) return report_error(metrics.error());
    if (Status output = check_output(options); !output) return report_error(output.error());
    auto image = display::read_exr(options.image);
    if (!image) return report_error(image.error());
    auto reference = display::read_exr(options.reference);
    if (!reference) return report_error(reference.error());
    note_data_window(*image);
    note_data_window(*reference);
    auto pair = display::LayerPair::make(*image, *reference, options.layer);
    if (!pair) return report_error(pair.error());
    std::vector<Measured> measured;
    for (const display::AnyMetric& metric : *metrics)
        measured.push_back({metric.name, pair->value(metric, options.component())});
    const bool all = options.metric == "all";
    if (!all && !measured.front().value) return report_error(measured.front().value.error());
    if (options.writes)
        if (Status written = write_errors(options, metrics->front(), *pair); !written)
            return report_error(written.error());
    if (options.json) print_line(json_text(json_of(options, measured), 2));
    else if (all) print_table(measured);
    else print_line(number_text(*measured.front().value, 9));
    return exit_holds;
}

std::string formulas() {
    std::string text = "Formulas (a: image, b: reference):";
    const std::string indent(23, ' ');
    for (const display::AnyMetric& each : display::all_metrics()) {
        text += "\n  " + each.name + std::string(21 - each.name.size(), ' ');
        for (const char c : each.formula) text += c == '\n' ? "\n" + indent : std::string(1, c);
    }
    return text +
           "\nPrimaries are converted when the files' chromaticities differ. The ratio to a black reference "
           "is\nundefined: an error with exit code 2, or a dash with --metric all.";
}

}  // namespace

void add_compare_command(CLI::App& app, CommandContext& context) {
    CLI::App* command =
        app.add_subcommand("compare", "Prints the error of A.exr against the reference B.exr, and shows where it is.");
    auto options = std::make_shared<CompareOptions>();
    command->add_option("A.exr", options->image, "the image")->required()->option_text("(required)");
    command->add_option("B.exr", options->reference, "the reference")->required()->option_text("(required)");
    command->add_option("--metric", options->metric, "the metric, one of those below, or all; default relmse")
        ->option_text("NAME|all");
    command->add_option("--layer", options->layer, "layer to compare; default beauty")->option_text("NAME");
    command->add_option("--channel", options->channel, "R, G, B or Y (luminance); default: the mean over R, G and B")
        ->option_text("R|G|B|Y")
        ->check(CLI::IsMember({"R", "G", "B", "Y"}));
    CLI::Option* output =
        command
            ->add_option(
                "-o,--output", options->output,
                "writes the metric of each pixel, as numbers (OpenEXR) or colours (PNG); the colour scale is printed")
            ->option_text("ERROR.exr|png");
    command->add_flag("--json", options->json, "prints the result as JSON");
    command->footer(formulas());
    command->callback([options, output, &context] {
        options->writes = output->count() > 0;
        context.exit_code = run_compare(*options);
    });
}

}  // namespace raylex::experiments
