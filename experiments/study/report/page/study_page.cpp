#include "experiments/study/report/page/study_page.h"

#include <algorithm>

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

/// The verdicts in a few lines, before any table.
std::string escaped_list(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + escape_html(name);
    return text;
}

bool declared_unbiased(const Study& study, const std::string& variant) {
    return std::any_of(study.variants.begin(), study.variants.end(),
                       [&](const MethodVariant& each) { return each.name == variant && each.unbiased; });
}

std::string extent_summary(const Study& study) {
    const Experiment& experiment = *study.experiment;
    std::size_t failed = 0;
    double seconds = 0;
    for (const Cell& cell : experiment.cells) {
        failed += cell.failed ? 1 : 0;
        seconds += cell.wall_seconds;
    }
    return "<p class=\"faint\">" + counted(experiment.cells.size() - failed, "cell", "cells") + " done" +
           (failed > 0 ? ", " + std::to_string(failed) + " failed" : "") +
           (experiment.missing.empty() ? "" : ", " + std::to_string(experiment.missing.size()) + " not run") + "; " +
           counted(experiment.scenes.size(), "scene", "scenes") + ", " +
           counted(study.variants.size(), "variant", "variants") + "; " + duration_text(seconds) + " of rendering" +
           (experiment.cpu_clock ? "; times below are CPU seconds of all threads" : "; times below are wall seconds") +
           ".</p>\n";
}

std::string split_summary(const Experiment& experiment) {
    std::size_t splits = 0, broken = 0;
    for (const Cell& cell : experiment.cells) {
        if (cell.failed) continue;
        splits += cell.splits.size();
        for (const PartitionVerdict& split : cell.splits) broken += split.holds ? 0 : 1;
    }
    if (splits == 0) return {};
    return mark(broken == 0,
                broken == 0 ? "Every split sums" : counted(broken, "split does", "splits do") + " not sum") +
           (broken < 2 ? "to what it splits, in " : "to what they split, in ") +
           counted(splits, "verdict", "verdicts") + " over all cells.</li>\n";
}

std::string bias_summary(const Study& study) {
    std::vector<std::string> wrong, doubtful;
    std::size_t tested = 0;
    for (const BiasEntry& entry : study.bias) {
        tested += entry.verdict.tested ? 1 : 0;
        if (!entry.verdict.differs || !declared_unbiased(study, entry.variant)) continue;
        const std::string name = entry.variant + " on " + entry.scene;
        std::vector<std::string>& list = entry.convicts() ? wrong : doubtful;
        if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
    }
    std::erase_if(doubtful,
                  [&](const std::string& name) { return std::find(wrong.begin(), wrong.end(), name) != wrong.end(); });
    std::string text;
    if (!wrong.empty())
        text += mark(false, "Declared unbiased but differs from the reference:") + escaped_list(wrong) + ".</li>\n";
    else if (tested > 0)
        text += mark(true, "No method declared unbiased") + "was found to differ from its reference, in " +
                counted(tested, "test", "tests") + " of channels.</li>\n";
    if (!doubtful.empty())
        text += "<li><span class=\"warn\">No verdict on bias:</span> a few rare samples decide for " +
                escaped_list(doubtful) + ".</li>\n";
    return text;
}

std::string curve_summary(const Study& study) {
    std::vector<std::string> shallow;
    std::size_t heavy = 0, judged = 0;
    for (const Curve& curve : study.curves) {
        judged += curve.slope.samples && declared_unbiased(study, curve.variant) ? 1 : 0;
        if (curve.slope.too_shallow)
            shallow.push_back(curve.variant + " on " + curve.scene + " (" + curve.channel + ")");
        heavy += std::any_of(curve.points.begin(), curve.points.end(),
                             [](const BudgetPoint& p) { return p.group.heavy_tail; });
    }
    std::string text;
    if (!shallow.empty())
        text += mark(false, "Falls slower than an unbiased method:") + escaped_list(shallow) + ". Of " +
                counted(judged, "curve", "curves") + " judged at 95 %, one in 40 does so by chance.</li>\n";
    if (heavy > 0)
        text += "<li><span class=\"warn\">Heavy tail, interval not valid:</span> on " +
                counted(heavy, "curve", "curves") + " a few rare samples decide the error.</li>\n";
    return text;
}

std::string summary(const Study& study) {
    std::string text = extent_summary(study) + "<ul class=\"summary\">\n" + split_summary(*study.experiment) +
                       bias_summary(study) + curve_summary(study);
    if (const std::string load = study.experiment->load_warning(); !load.empty())
        text += "<li><span class=\"warn\">Times:</span> " + escape_html(load) + ".</li>\n";
    std::vector<std::string> without;
    for (const SceneInfo& scene : study.experiment->scenes)
        if (scene.reference.empty()) without.push_back(scene.name);
    if (!without.empty())
        text +=
            "<li>No reference, so neither errors nor what they cost are known: " + escaped_list(without) + ".</li>\n";
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

/// Those of the plots that there are, beside each other, with one legend.
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
            panels += "<h3>What is worth its time</h3>\n<div class=\"beside\">" +
                      plot_group(known, {front_id(index, curve.channel)}) + "<div>" +
                      front_table(study, scene.name, curve.channel) +
                      "</div></div>\n<h3>Error by spatial frequency</h3>\n" +
                      plot_group(known, {spectrum_id(index, curve.channel)});
        panels += "</div>\n";
    }
    std::string html = "<section class=\"scene-study\" id=\"scene-" + std::to_string(index) +
                       "\">\n<h2>What accuracy costs: " + escape_html(scene.name) + "</h2>\n";
    if (items.empty() && scene.reference.empty()) return {};  // the summary says why
    if (items.empty())
        return html + "<p class=\"faint\">Nothing was measured on this scene; see the omissions.</p></section>\n";
    html += choices("Channel", items) + panels;
    html += deviation_maps(study, scene);
    if (const std::string costs = effect_costs_table(study, scene.name); !costs.empty())
        html += "<h3>What each effect costs</h3>\n<div class=\"beside\">" +
                plot_group(known, {effect_costs_id(index)}) + "<div>" + costs + "</div></div>\n";
    if (const std::string effects = effects_table(study, scene); !effects.empty())
        html += "<h3>What each setting buys</h3>\n" + effects;
    return html + "<h3>Bias against the reference</h3>\n" + words_list(study, scene) + bias_table(study, scene) +
           "</section>\n";
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
        predictions_text(study) + "</section>\n<section id=\"references\"><h2>References</h2>\n" +
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
