// raylex report: shows images on one HTML page.
#include <filesystem>
#include <memory>

#include "display/output/atomic_file.h"
#include "display/output/color/color_manager.h"
#include "experiments/cli/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/report/page.h"

namespace raylex::experiments {
namespace {

struct ReportOptions {
    std::vector<std::string> images;
    std::string page, ocio;
    PageOptions options;
};

int run_report(const ReportOptions& report) {
    // The page must never overwrite an image, which may have taken hours.
    for (const std::string& image : report.images) {
        std::error_code failed;
        if (image == report.page || std::filesystem::equivalent(image, report.page, failed))
            return report_error("the page '" + report.page +
                                "' is one of the images; expected a different file, such as page.html");
    }
    take_standard_output_for(report.page);
    if (!is_standard_output(report.page))
        if (Status writable = display::check_writable(report.page); !writable) return report_error(writable.error());
    auto color = display::ColorManager::open(report.ocio);
    if (!color) return report_error(color.error());
    auto page = make_page(report.images, *color, report.options);
    if (!page) return report_error(page.error());
    Status written = write_text(report.page, *page);
    if (!written) return report_error(written.error());
    print_line((is_standard_output(report.page) ? "standard output" : report.page) + ": " +
               size_text(static_cast<double>(page->size())));
    return exit_holds;
}

}  // namespace

void add_report_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "report", "Makes one self-contained HTML page of every layer, with expressions, checks and provenance.");
    auto options = std::make_shared<ReportOptions>();
    command->add_option("OUT.exr", options->images, "the images, in the order of the page")
        ->required()
        ->option_text("...");
    command->add_option("-o,--output", options->page, "the page to write; -: standard output")
        ->required()
        ->option_text("PAGE.html");
    command->add_option("--ocio", options->ocio, "OpenColorIO config; default: $OCIO, else raylex's own")
        ->option_text("FILE");
    command->add_option("--display", options->options.display, "display of the config; default: its first")
        ->option_text("NAME");
    command->add_option("--view", options->options.view, "view of the display; default: its first")
        ->option_text("NAME");
    command
        ->add_option("--size", options->options.largest_side,
                     "largest side of the pictures in pixels, reduced by a whole factor; default: the full size, "
                     "reduced only if the page would exceed about 50 MB")
        ->option_text("N")
        ->check(CLI::Range(16, 8192));
    command->footer(
        "Name a path atlas after the image of its render. The page then shows the path strings of the pixel under the "
        "pointer, and the\nlayer of any expression that is typed in. Statistics are shown when OUT.json, as --stats "
        "writes it, stands beside "
        "OUT.exr.");
    command->callback([options, &context] { context.exit_code = run_report(*options); });
}

}  // namespace raylex::experiments
