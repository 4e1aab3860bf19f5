#include "experiments/study/report/study_report.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "display/output/atomic_file.h"
#include "experiments/cli/command_line.h"
#include "experiments/cli/console.h"
#include "experiments/study/report/assets.h"
#include "experiments/study/report/study_files.h"
#include "experiments/study/report/study_page.h"

namespace raylex::experiments {
namespace {

Status write_plots(const std::string& directory, const std::vector<Plot>& plots, const std::string& d3) {
    Result<PlotDrawer> drawer = PlotDrawer::create(d3);
    if (!drawer) return std::move(drawer).error();
    for (const Plot& plot : plots) {
        nlohmann::ordered_json spec = nlohmann::ordered_json::parse(plot.json);
        spec["standalone"] = true;
        Result<std::string> svg = drawer->draw(spec.dump());
        if (!svg) return std::move(svg).error();
        Status written = display::write_text_file(directory + "/" + plot.file, *svg);
        if (!written) return written;
    }
    return success();
}

}  // namespace

int write_study_report(const Experiment& experiment, const StudyReportOptions& options) {
    Result<std::string> d3 = read_d3();
    if (!d3) return report_error(d3.error());
    Result<Study> study = study_of(experiment, options);
    if (!study) return report_error(study.error());
    const std::string directory = options.directory.empty() ? experiment.directory : options.directory;
    std::error_code failed;
    std::filesystem::create_directories(directory + "/plots", failed);
    if (failed) return report_error("the folder '" + directory + "/plots' cannot be made: " + failed.message());
    const std::vector<Plot> plots = plots_of(*study);
    const Pictures pictures = pictures_of(*study);
    for (const std::string& each : pictures.left_out) print_warning("no picture of " + each);
    const std::string page = study_page(*study, plots, pictures, *d3);
    Status written = write_plots(directory + "/plots", plots, *d3);
    if (written) written = display::write_text_file(directory + "/results.csv", results_csv(*study));
    if (written) written = display::write_text_file(directory + "/results.jsonl", results_jsonl(*study));
    if (written) written = display::write_text_file(directory + "/report.html", page);
    if (!written) return report_error(written.error());
    if (!study->omissions.empty())
        print_warning(std::to_string(study->omissions.size()) + " omissions, listed in the report; the first: " +
                      study->omissions.front().what + ": " + study->omissions.front().reason);
    print_line(directory + "/report.html: " + size_text(static_cast<double>(page.size())) +
               "; results.csv, results.jsonl and " + std::to_string(plots.size()) + " plots beside it");
    return exit_holds;
}

}  // namespace raylex::experiments
