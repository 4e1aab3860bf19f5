// Tables of a study's page about the record: settings, omissions and provenance.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <span>

#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/study/metrics.h"
#include "experiments/study/plan/plan.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/study_tables.h"

namespace raylex::experiments {
namespace {

std::string number_cell(const std::string& text) {
    return "<td class=\"number\">" + text + "</td>";
}

/// Returns the residual map of the worst cell of a failed split, if the cell's files still exist.
std::string residual_picture(const Study& study, const std::string& scene, const std::string& partition,
                             const std::string& run_id) {
    for (const StudyRun& cell : study.experiment->runs) {
        if (cell.id != run_id) continue;
        std::ifstream file(cell.directory + "/" + partition + ".residual.png", std::ios::binary);
        const std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
        if (bytes.empty()) return {};
        const std::span<const unsigned char> png(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
        return "<figure class=\"residual\"><img alt=\"where " + escape_html(partition) + " fails\" src=\"" +
               data_uri(png) + "\"><figcaption>" + escape_html(scene + ", " + partition) + "</figcaption></figure>\n";
    }
    return {};
}

/// Returns the relative error of a channel, from its variance between replicates. Negative if there is only one
/// replicate, or if a file is missing.
double error_between(const std::vector<const StudyRun*>& cells, const std::string& channel) {
    const auto count = static_cast<double>(cells.size());
    std::vector<double> beauty, mean;
    std::vector<std::vector<double>> images;
    for (const StudyRun* cell : cells) {
        const auto whole = read_mean(cell->directory, "beauty"), part = read_mean(cell->directory, channel);
        if (!whole || !part || count < 2) return -1;
        beauty.resize(whole->values.size());
        mean.resize(whole->values.size());
        for (std::size_t i = 0; i < mean.size(); ++i) {
            beauty[i] += whole->values[i] / count;
            mean[i] += part->values[i] / count;
        }
        images.push_back(part->values);
    }
    double squares = 0;
    for (std::vector<double>& image : images) {
        for (std::size_t i = 0; i < image.size(); ++i) image[i] += beauty[i] - mean[i];
        squares += display::measure_errors(image, beauty)[display::ErrorMetric::relmse_mean];
    }
    return relative_error(squares / (count - 1));
}

}  // namespace

std::string splits_table(const Study& study) {
    struct Count {
        int holds = 0, fails = 0;
        double worst = 0;
        std::string worst_cell;
    };
    std::map<std::array<std::string, 3>, Count> counts;  // scene, partition, variant
    for (const StudyRun& cell : study.experiment->runs)
        for (const PartitionResult& split : cell.splits) {
            Count& count = counts[{cell.scene, split.partition, variant_name(cell)}];
            ++(split.holds ? count.holds : count.fails);
            if (count.worst_cell.empty() || split.worst_relative_error > count.worst) {
                count.worst = split.worst_relative_error;
                count.worst_cell = cell.id;
            }
        }
    if (counts.empty()) return "<p class=\"faint\">No cell declares a partition, so there is nothing to check.</p>\n";
    std::string rows, pictures;
    for (const auto& [key, count] : counts) {
        rows += "<tr>" + text_cell(key[0]) + text_cell(key[1]) + text_cell(key[2]) +
                (count.fails == 0 ? "<td class=\"holds\">holds</td>" : "<td class=\"fails\">does not hold</td>") +
                number_cell(std::to_string(count.holds) + " of " + std::to_string(count.holds + count.fails)) +
                number_cell(number_text(count.worst)) + text_cell(count.worst_cell) + "</tr>\n";
        if (count.fails > 0) pictures += residual_picture(study, key[0], key[1], count.worst_cell);
    }
    if (!pictures.empty())
        pictures =
            "<p>Failed splits, in their worst cell. Black to violet: within the bound of rounding; red to pale "
            "yellow: "
            "beyond it, light that is counted twice or missed.</p>\n<div class=\"residuals\">" +
            pictures + "</div>\n";
    return table(
               "<th>Scene</th><th>Partition</th><th>Variant</th><th>Verdict</th><th>Cells in which it holds</th>"
               "<th class=\"formula\">Worst pixel<code>|sum of layers - whole| / (sum of |layers| + "
               "|whole|)</code></th><th>in "
               "cell</th>",
               rows) +
           pictures;
}

std::string costs_table(const Study& study) {
    // By variant and scene: time by phase of the largest cells.
    std::string rows;
    for (const SceneInfo& scene : study.experiment->scenes)
        for (const MethodVariant& variant : study.variants) {
            std::vector<std::pair<std::string, Phase>> phases;
            double wall = 0, cpu = 0, rays = 0, invalid = 0, memory = 0, count = 0;
            for (const StudyRun& cell : study.experiment->runs) {
                if (cell.failed || cell.scene != scene.name || variant_name(cell) != variant.name) continue;
                count += 1;
                wall += cell.wall_seconds;
                cpu += cell.cpu_seconds;
                rays += static_cast<double>(cell.rays);
                invalid += static_cast<double>(cell.invalid_samples);
                memory = std::max(memory, static_cast<double>(cell.peak_memory_bytes));
                for (const Phase& phase : cell.phases) {
                    auto found = std::find_if(phases.begin(), phases.end(),
                                              [&](const auto& each) { return each.first == phase.name; });
                    if (found == phases.end()) found = phases.insert(phases.end(), {phase.name, {}});
                    found->second.wall_seconds += phase.wall_seconds;
                }
            }
            if (count == 0) continue;
            std::string itemised;
            for (const auto& [name, phase] : phases)
                itemised += (itemised.empty() ? "" : ", ") + name + " " + duration_text(phase.wall_seconds);
            rows += "<tr>" + text_cell(scene.name) + text_cell(variant.name) + number_cell(number_text(count)) +
                    number_cell(duration_text(wall)) + number_cell(duration_text(cpu)) + text_cell(itemised) +
                    number_cell(rays > 0 ? number_text(rays / wall * 1e-6) : "&ndash;") +
                    number_cell(number_text(invalid, 9)) + number_cell(memory > 0 ? size_text(memory) : "&ndash;") +
                    "</tr>\n";
        }
    return table(
        "<th>Scene</th><th>Variant</th><th>Cells</th><th>Wall time</th><th>CPU time</th><th>Wall time by phase</th>"
        "<th>Million rays per second</th><th>Contributions not finite</th><th>Peak memory</th>",
        rows);
}

std::string passes_table(const Study& study) {
    std::map<std::string, std::vector<const StudyRun*>> replicates;  // by scene, variant and budget, in the order of it
    std::vector<std::string> order;
    for (const StudyRun& cell : study.experiment->runs) {
        if (cell.failed || cell.passes.empty()) continue;
        const std::string key = cell.scene + "\n" + variant_name(cell) + "\n" + number_text(cell.budget, 17);
        if (!replicates.contains(key)) order.push_back(key);
        replicates[key].push_back(&cell);
    }
    std::string rows;
    for (const std::string& key : order) {
        const std::vector<const StudyRun*>& cells = replicates.at(key);
        const StudyRun& first = *cells.front();
        for (std::size_t i = 0; i < first.passes.size(); ++i) {
            double samples = 0, seconds = 0;
            for (const StudyRun* cell : cells) {
                samples += cell->passes[i].samples_per_pixel / static_cast<double>(cells.size());
                seconds += cell->passes[i].cpu_seconds / static_cast<double>(cells.size());
            }
            const double error = error_between(cells, "pass_" + first.passes[i].name);
            rows += "<tr>" + text_cell(first.scene) + text_cell(variant_name(first)) +
                    text_cell(budget_text(first.budget_kind, first.budget)) + text_cell(first.passes[i].name) +
                    text_cell(first.passes[i].method) + number_cell(number_text(samples)) +
                    number_cell(duration_text(seconds)) + number_cell(error >= 0 ? percent_text(error) : "&ndash;") +
                    "</tr>\n";
        }
    }
    if (rows.empty()) return {};
    return "<h3>Passes</h3>\n" +
           table(
               "<th>Scene</th><th>Variant</th><th>Budget</th><th>Pass</th><th>Method</th><th>Samples per pixel</th>"
               "<th>CPU time</th><th class=\"formula\">Relative error<code>sqrt(mean(Var(pass) / (b^2 + (0.1 m)^2))), "
               "b the mean beauty of the replicates</code></th>",
               rows);
}

std::string references_table(const Study& study) {
    std::string rows;
    for (const SceneInfo& scene : study.experiment->scenes)
        rows += "<tr>" + text_cell(scene.name) + text_cell(scene.file) +
                number_cell(std::to_string(scene.width) + " x " + std::to_string(scene.height)) +
                text_cell(scene.reference.empty() ? "none" : scene.reference_method) +
                number_cell(scene.reference_samples > 0 ? std::to_string(scene.reference_samples) : "&ndash;") +
                number_cell(scene.reference.empty() || scene.reference_relative_error < 0
                                ? "not known"
                                : percent_text(scene.reference_relative_error)) +
                "</tr>\n";
    return table(
        "<th>Scene</th><th>File</th><th>Pixels</th><th>Reference by</th><th>Samples per pixel</th>"
        "<th class=\"formula\">Its standard error<code>sqrt(mean(Var(b))) / sqrt(mean(b^2))</code></th>",
        rows);
}

std::string omissions_table(const Study& study) {
    if (study.omissions.empty()) return "<p>None: every planned cell was run and measured, and is in the tables.</p>\n";
    std::string rows;
    for (const Omission& omission : study.omissions)
        rows += "<tr>" + text_cell(omission.what) + text_cell(omission.reason) + "</tr>\n";
    return table("<th>Item</th><th>Reason</th>", rows);
}

std::string provenance_table(const Study& study) {
    const Experiment& experiment = *study.experiment;
    std::string rows =
        "<tr><td>configuration's hash</td><td><code>" + escape_html(experiment.config_hash) + "</code></td></tr>\n";
    for (const auto& [name, value] : experiment.provenance)
        rows += "<tr>" + text_cell(name) + text_cell(value) + "</tr>\n";
    if (experiment.time.render > 0)
        rows +=
            "<tr>" + text_cell("runner overhead") +
            text_cell(number_text(experiment.time.overhead_percent()) + " % of " + number_text(experiment.time.render) +
                      " s of rendering, plus " + number_text(experiment.time.warm_up) + " s of warm-up and " +
                      number_text(experiment.time.references) + " s for references") +
            "</tr>\n";
    std::string methods;
    for (const MethodInfo& method : experiment.methods) {
        std::string settings;
        for (const auto& [key, value] : method.settings)
            settings += (settings.empty() ? "" : ", ") + key + " = " + value;
        methods += "<tr>" + text_cell(method.name) +
                   text_cell(method.command.empty() ? "integrator " + method.integrator : "command " + method.command) +
                   text_cell(settings) + text_cell(method.unbiased ? "unbiased" : "biased") + "</tr>\n";
    }
    std::string seeds;
    for (const StudyRun& cell : experiment.runs)
        seeds += "<tr>" + text_cell(cell.id) + number_cell(std::to_string(cell.seed)) +
                 number_cell(std::to_string(cell.samples_per_pixel)) + number_cell(number_text(cell.wall_seconds)) +
                 number_cell(number_text(cell.cpu_seconds)) + text_cell(cell.failed ? "failed" : cell.isa) + "</tr>\n";
    return table("<th>What</th><th></th>", rows) +
           table("<th>Method</th><th>Made by</th><th>Settings</th><th>Declared</th>", methods) +
           "<details><summary>Cells and seeds</summary>\n" +
           table(
               "<th>Cell</th><th>Seed</th><th>Samples per pixel</th><th>Wall seconds</th><th>CPU "
               "seconds</th><th>Instruction set</th>",
               seeds) +
           "</details>\n<details><summary>The configuration</summary>\n<pre>" + escape_html(experiment.config_text) +
           "</pre></details>\n";
}

}  // namespace raylex::experiments
