// Experiments: running, reading and judging them by the functions of `raylex experiment`.
#include <pybind11/stl.h>

#include "experiments/job/text/json.h"
#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/run_control.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/study_report.h"
#include "experiments/study/results.h"
#include "experiments/study/run/runner.h"

namespace raylex::python {

using namespace pybind11::literals;

namespace {

py::dict run(const std::string& config, const std::string& directory, const std::vector<std::string>& overrides,
             bool resume, bool retry, bool verbose) {
    const auto control = std::make_shared<RunControl>();
    const experiments::RunOutcome outcome = watched(control, [&] {
        const auto read = take(experiments::read_experiment_config(config, overrides));
        // Runs in this process, because a fork would have Python's lock and the threads of earlier renders in an
        // unknown state.
        // state.
        experiments::RunRequest request;
        request.directory = directory;
        request.resume = resume;
        request.retry = retry;
        request.isolated = false;
        request.quiet = !verbose;
        return take(experiments::run_experiment(read, request, &control->stop_flag()));
    });
    control->rethrow();
    return py::dict("done"_a = outcome.done, "failed"_a = outcome.failed, "left"_a = outcome.left,
                    "splits_broken"_a = outcome.splits_broken, "references_failed"_a = outcome.references_failed);
}

/// Returns results.jsonl, results.csv and verdicts of the finished cells, and the specifications of their plots. Writes
/// no file.
/// written.
py::dict study(const std::string& directory) {
    py::dict result;
    std::string lines, table;
    std::vector<std::string> results;
    bool cpu_clock = false;
    std::vector<std::pair<std::string, std::string>> plots;
    unlocked([&] {
        const experiments::Experiment experiment = take(experiments::read_experiment(directory));
        cpu_clock = experiment.cpu_clock;
        const experiments::Study checked = take(experiments::study_of(experiment, {}));
        lines = experiments::results_jsonl(checked);
        table = experiments::results_csv(checked);
        results = experiments::result_lines(checked);
        for (const experiments::Plot& plot : experiments::plots_of(checked)) plots.emplace_back(plot.file, plot.json);
    });
    result["jsonl"] = lines;
    result["csv"] = table;
    result["verdicts"] = results;
    result["clock"] = cpu_clock ? "cpu_seconds" : "wall_seconds";
    result["plots"] = plots;
    return result;
}

py::array_t<double> cell_mean(const std::string& directory, const std::string& channel) {
    experiments::PixelArray array = unlocked([&] { return take(experiments::read_mean(directory, channel)); });
    return owning_array(std::move(array.values),
                        {static_cast<py::ssize_t>(array.height), static_cast<py::ssize_t>(array.width),
                         static_cast<py::ssize_t>(array.components)});
}

py::list runs(const std::string& directory) {
    const experiments::Experiment experiment = unlocked([&] { return take(experiments::read_experiment(directory)); });
    py::list list;
    for (const experiments::StudyRun& cell : experiment.runs) {
        py::dict row("id"_a = cell.id, "scene"_a = cell.scene, "method"_a = cell.method,
                     "budget_kind"_a = experiments::budget_kind_name(cell.budget_kind), "budget"_a = cell.budget,
                     "replicate"_a = cell.replicate, "seed"_a = cell.seed, "failed"_a = cell.failed,
                     "failure"_a = cell.failure, "samples_per_pixel"_a = cell.samples_per_pixel,
                     "wall_seconds"_a = cell.wall_seconds, "cpu_seconds"_a = cell.cpu_seconds, "rays"_a = cell.rays,
                     "directory"_a = cell.directory);
        for (const auto& [key, value] : cell.settings) row[py::str(key)] = value;
        list.append(row);
    }
    return list;
}

}  // namespace

void add_study(py::module_& module) {
    module.def("_run_experiment", &run, "config"_a, "directory"_a, "overrides"_a, "resume"_a, "retry"_a, "verbose"_a);
    module.def("_study", &study, "directory"_a);
    module.def("_cells", &runs, "directory"_a);
    module.def("_cell_mean", &cell_mean, "directory"_a, "channel"_a);
    module.def(
        "_write_report",
        [](const std::string& directory, const std::string& to) {
            return unlocked([&] {
                experiments::StudyReportOptions options;
                options.directory = to;
                return experiments::write_study_report(take(experiments::read_experiment(directory)), options);
            });
        },
        "directory"_a, "to"_a);
}

}  // namespace raylex::python
