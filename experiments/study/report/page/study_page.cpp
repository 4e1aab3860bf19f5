#include "experiments/study/report/page/study_page.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/study/report/page/assets.h"
#include "experiments/study/report/page/effect_costs.h"
#include "experiments/study/report/page/picture_viewers.h"
#include "experiments/study/report/page/study_tables.h"

namespace raylex::experiments {
namespace {

std::string mark(bool good, const std::string& text) {
    return "<li><span class=\"" + std::string(good ? "holds" : "fails") + "\">" + text + "</span> ";
}

std::string escaped_list(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + escape_html(name);
    return text;
}

std::string extent_summary(const Study& study) {
    const Experiment& experiment = *study.experiment;
    std::size_t failed = 0;
    double seconds = 0;
    for (const StudyRun& cell : experiment.runs) {
        failed += cell.failed ? 1 : 0;
        seconds += cell.wall_seconds;
    }
    return "<p class=\"faint\">" + counted(experiment.runs.size() - failed, "cell", "cells") + " done" +
           (failed > 0 ? ", " + std::to_string(failed) + " failed" : "") +
           (experiment.missing.empty() ? "" : ", " + std::to_string(experiment.missing.size()) + " not run") + "; " +
           counted(experiment.scenes.size(), "scene", "scenes") + ", " +
           counted(study.variants.size(), "variant", "variants") + "; " + duration_text(seconds) + " of rendering" +
           (experiment.cpu_clock ? "; times below are CPU seconds of all threads" : "; times below are wall seconds") +
           ".</p>\n";
}

std::string split_summary(const Experiment& experiment) {
    std::size_t splits = 0, broken = 0;
    for (const StudyRun& cell : experiment.runs) {
        if (cell.failed) continue;
        splits += cell.splits.size();
        for (const PartitionResult& split : cell.splits) broken += split.holds ? 0 : 1;
    }
    if (splits == 0) return {};
    return mark(broken == 0,
                broken == 0 ? "Every split sums" : counted(broken, "split does", "splits do") + " not sum") +
           (broken < 2 ? "to its whole, in " : "to their wholes, in ") + counted(splits, "verdict", "verdicts") +
           " over all cells.</li>\n";
}

/// Names in the order of discovery, each with a text.
using Findings = std::vector<std::pair<std::string, std::string>>;

void add_finding(Findings& findings, const std::string& name, const std::string& text) {
    const auto known =
        std::find_if(findings.begin(), findings.end(), [&](const auto& each) { return each.first == name; });
    if (known == findings.end()) findings.emplace_back(name, text);
    else if (known->second != text) known->second += ", " + text;
}

/// Returns "<head> a (text); b (text).", or nothing without findings. With many variants, only the first are named.
std::string finding_line(const std::string& type, const std::string& head, const Findings& findings,
                         const std::string& end = ".") {
    constexpr std::size_t most = 8;
    if (findings.empty()) return {};
    std::string text;
    for (std::size_t i = 0; i < std::min(most, findings.size()); ++i) {
        const auto& [name, what] = findings[i];
        text += (text.empty() ? "" : "; ") + escape_html(name + (what.empty() ? "" : " (" + what + ")"));
    }
    if (findings.size() > most) text += "; and " + std::to_string(findings.size() - most) + " more, in the tables";
    return "<li><span class=\"" + type + "\">" + head + "</span> " + text + end + "</li>\n";
}

std::string bias_summary(const Study& study) {
    std::map<BiasConclusion, Findings> found;
    std::size_t clean = 0;
    double largest = 0;
    for (const BiasEntry& entry : study.bias) {
        if (!study.unbiased(entry.variant)) continue;
        const BiasConclusion conclusion = entry.conclusion();
        add_finding(found[conclusion], entry.variant + " on " + entry.scene,
                    conclusion == BiasConclusion::differs       ? entry.channel + ": " + finding_of(study, entry)
                    : conclusion == BiasConclusion::omits_paths ? entry.omitted
                    : conclusion == BiasConclusion::cannot_tell && !entry.reason().empty()
                        ? entry.channel + ": " + entry.reason()
                        : entry.channel);
        if (conclusion != BiasConclusion::none_found) continue;
        ++clean;
        largest = std::max(largest, entry.result.detectable_whole);
    }
    std::string text =
        finding_line("fails", "Declared unbiased but differs from the reference:", found[BiasConclusion::differs]);
    if (clean > 0)
        text += mark(true, "No bias found") + "in " + counted(clean, "test", "tests") +
                " of channels; any bias above " + percent_text(largest) +
                " of the mean would be found with a probability of 90 %.</li>\n";
    return text +
           finding_line("warn", "Cannot tell about bias:", found[BiasConclusion::cannot_tell],
                        ". If no reason is given, a bias of " + percent_text(largest_hidden_bias) +
                            " of the mean would be missed.") +
           finding_line("warn",
                        "No verdict on bias, because a few rare samples dominate:", found[BiasConclusion::rare]) +
           finding_line("note", "Not judged, because the method declares that it does not find such paths:",
                        found[BiasConclusion::omits_paths]);
}

std::string curve_summary(const Study& study) {
    Findings shallow, nearing;
    std::size_t heavy = 0, judged = 0;
    for (const Curve& curve : study.curves) {
        judged += curve.slope.samples && study.unbiased(curve.variant) ? 1 : 0;
        const std::string name = curve.variant + " on " + curve.scene;
        if (curve.slope.too_shallow) add_finding(shallow, name, curve.channel);
        if (curve.slope.nears) add_finding(nearing, name, curve.channel);
        heavy += std::any_of(curve.points.begin(), curve.points.end(),
                             [](const BudgetPoint& p) { return p.group.heavy_tail; });
    }
    const std::string text =
        finding_line(
            "fails", "Falls slower than an unbiased method at the last octaves:", shallow,
            ". At 95 %, one in 40 of " + counted(judged, "judged curve", "judged curves") + " does so by chance.") +
        finding_line("warn",
                     "The error does not fall as 1 / samples yet, but approaches it with every octave:", nearing);
    if (heavy == 0) return text;
    return text + "<li><span class=\"warn\">Heavy tail, interval not valid:</span> on " +
           counted(heavy, "curve", "curves") + " a few rare samples dominate the error.</li>\n";
}

/// Lists references that are too coarse for the errors in the tables.
std::string reference_summary(const Study& study) {
    const double finest = target_errors.back() / 2;
    Findings coarse, unknown;
    for (const SceneInfo& scene : study.experiment->scenes) {
        double worst = 0;
        std::string channel;
        for (const Curve& curve : study.curves)
            for (const BudgetPoint& point : curve.points)
                if (curve.scene == scene.name && curve.region.empty() && point.excess > worst) {
                    worst = point.excess;
                    channel = curve.channel;
                }
        if (std::sqrt(worst) > finest)
            add_finding(coarse, scene.name, percent_text(std::sqrt(worst)) + " in " + channel);
        if (scene.reference_relative_error < 0 && !scene.reference.empty()) add_finding(unknown, scene.name, "");
    }
    const std::string lines = finding_line("warn",
                                           "Coarse references, whose own error exceeds " + percent_text(finest) +
                                               ", half of the smallest error in the table of times:",
                                           coarse) +
                              finding_line("warn", "References whose own error is unknown:", unknown);
    return lines.empty() ? lines : "<ul class=\"summary\">\n" + lines + "</ul>\n";
}

/// Returns the summary of findings at the top of the page.
std::string summary(const Study& study) {
    std::string text = extent_summary(study) + reference_summary(study) + comparison_table(study) +
                       "<ul class=\"summary\">\n" + split_summary(*study.experiment) + bias_summary(study) +
                       curve_summary(study);
    if (const std::string load = study.experiment->load_warning(); !load.empty())
        text += "<li><span class=\"warn\">Times:</span> " + escape_html(load) + ".</li>\n";
    std::vector<std::string> without;
    for (const SceneInfo& scene : study.experiment->scenes)
        if (scene.reference.empty()) without.push_back(scene.name);
    if (!without.empty())
        text += "<li>No reference, so errors and their costs are unknown: " + escaped_list(without) + ".</li>\n";
    if (!study.omissions.empty())
        text += "<li><a href=\"#omissions\">" + counted(study.omissions.size(), "omission", "omissions") +
                "</a>, listed with the reason.</li>\n";
    return text + "</ul>\n";
}

std::string choices(const std::string& title, const std::vector<std::pair<std::string, std::string>>& items) {
    std::string html = "<div class=\"choices\"><span class=\"faint\">" + title + "</span>";
    for (const auto& [id, name] : items)
        html += "<button type=\"button\" aria-pressed=\"false\" data-choose=\"" + escape_html(id) + "\">" +
                escape_html(name) + "</button>";
    return html + "</div>\n";
}

/// Returns the plots that exist, side by side, with one legend.
std::string plot_group(const std::vector<Plot>& known, const std::vector<std::string>& ids) {
    std::string figures;
    for (const std::string& id : ids)
        if (std::any_of(known.begin(), known.end(), [&](const Plot& plot) { return plot.id == id; }))
            figures += "<figure class=\"plot\" data-plot=\"" + escape_html(id) + "\"></figure>";
    return "<div class=\"plots\">" + figures + "<div class=\"plot-legend\"></div></div>\n";
}

std::string scene_section(const Study& study, const std::vector<Plot>& known, std::size_t index) {
    const SceneInfo& scene = study.experiment->scenes[index];
    std::vector<std::pair<std::string, std::string>> items;
    std::string panels;
    for (const Curve& curve : study.curves) {
        if (curve.scene != scene.name) continue;
        const std::string id = plot_id(index, curve.channel, curve.region);
        if (std::any_of(items.begin(), items.end(), [&](const auto& each) { return each.first == id; })) continue;
        items.emplace_back(id, curve.channel + (curve.region.empty() ? "" : " in " + curve.region));
        std::string expression;
        for (const ChannelInfo& channel : scene.channels)
            if (channel.name == curve.channel) expression = channel.expression;
        panels += "<div data-panel=\"" + escape_html(id) + "\"" + (items.size() > 1 ? " hidden" : "") + ">\n" +
                  (expression.empty() ? "" : "<p><code>" + escape_html(expression) + "</code></p>\n") +
                  plot_group(known, {id, samples_id(index, curve.channel, curve.region)}) +
                  times_table(study, scene.name, curve.channel, curve.region) +
                  slopes_table(study, scene.name, curve.channel, curve.region) +
                  "<details><summary>All metrics at the largest budget</summary>\n" +
                  errors_table(study, scene.name, curve.channel, curve.region) + "</details>\n";
        if (curve.region.empty())
            panels += "<h3>Pareto front of error and time</h3>\n<div class=\"beside\">" +
                      plot_group(known, {front_id(index, curve.channel)}) + "<div>" +
                      front_table(study, scene.name, curve.channel) +
                      "</div></div>\n<h3>Error by spatial frequency</h3>\n" +
                      plot_group(known, {spectrum_id(index, curve.channel)});
        panels += "</div>\n";
    }
    std::string html = "<section class=\"scene-study\" id=\"scene-" + std::to_string(index) +
                       "\">\n<h2>Cost of accuracy: " + escape_html(scene.name) + "</h2>\n";
    if (items.empty() && scene.reference.empty()) return {};  // the summary has the reason
    if (items.empty())
        return html + "<p class=\"faint\">Nothing was measured on this scene; see the omissions.</p></section>\n";
    html += choices("Channel", items) + panels;
    html += deviation_maps(study, scene);
    if (const std::string costs = effect_costs_table(study, scene.name); !costs.empty())
        html += "<h3>Cost of each effect</h3>\n<div class=\"beside\">" + plot_group(known, {effect_costs_id(index)}) +
                "<div>" + costs + "</div></div>\n";
    if (const std::string effects = effects_table(study, scene); !effects.empty())
        html += "<h3>Benefit of each setting</h3>\n" + effects;
    return html + "<h3>Bias against the reference</h3>\n" + counterexample_list(study, scene) +
           bias_table(study, scene) + "</section>\n";
}

}  // namespace

std::string study_page(const Study& study, const std::vector<Plot>& plots, const Pictures& pictures,
                       const std::string& d3) {
    const Experiment& experiment = *study.experiment;
    std::string contents = "<nav class=\"contents\">", scenes;
    for (std::size_t i = 0; i < experiment.scenes.size(); ++i) {
        const std::string section = scene_section(study, plots, i);
        if (section.empty()) continue;
        contents += "<a href=\"#scene-" + std::to_string(i) + "\">" + escape_html(experiment.scenes[i].name) + "</a>";
        scenes += section;
    }
    for (const auto& [id, name] : {std::pair("images", "images"), std::pair("splits", "split sums"),
                                   std::pair("costs", "time and rays"), std::pair("references", "references"),
                                   std::pair("omissions", "omissions"), std::pair("provenance", "provenance")})
        contents += "<a href=\"#" + std::string(id) + "\">" + name + "</a>";
    Json data{{"plots", Json::object()}, {"pictures", picture_index(study, pictures)}};
    for (const Plot& plot : plots) data["plots"][plot.id] = parse_json(plot.json);

    std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
        "content=\"width=device-width, initial-scale=1\">\n<title>" +
        escape_html(experiment.name) + "</title>\n<style>" + std::string(page_style()) + std::string(study_style()) +
        "</style>\n</head>\n<body>\n<h1>" + escape_html(experiment.name) + "</h1>\n" + summary(study) + contents +
        "</nav>\n" + scenes + image_viewers(pictures) + "<section id=\"splits\"><h2>Split sums</h2>\n" +
        splits_table(study) + "</section>\n<section id=\"costs\"><h2>Time and rays</h2>\n" + costs_table(study) +
        passes_table(study) + predictions_text(study) + "</section>\n<section id=\"references\"><h2>References</h2>\n" +
        references_table(study) + "</section>\n<section id=\"omissions\"><h2>Omissions</h2>\n" +
        omissions_table(study) + "</section>\n<section id=\"provenance\"><h2>Provenance</h2>\n" +
        provenance_table(study) + "</section>\n";
    page.reserve(page.size() + d3.size() + pictures.bytes + pictures.encoded.size() * 80 + 1'000'000);
    page += "<script type=\"application/json\" id=\"study\">" + script_json(json_text(data)) + "</script>\n";
    for (std::size_t id = 0; id < pictures.encoded.size(); ++id)
        page += "<script type=\"text/plain\" id=\"picture-" + std::to_string(id) + "\">" + pictures.encoded[id] +
                "</script>\n";
    return page + "<script>" + d3 + "</script>\n<script>" + std::string(plot_script()) + "</script>\n<script>" +
           std::string(pixels_script()) + "</script>\n<script>" + std::string(panes_script()) + "</script>\n<script>" +
           std::string(bench_script()) + "</script>\n<script>" + std::string(study_script()) +
           "</script>\n</body>\n</html>\n";
}

}  // namespace raylex::experiments
