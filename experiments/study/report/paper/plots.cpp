#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "experiments/study/analysis/pareto.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/effect_costs.h"

namespace raylex::experiments {
namespace {

std::string budget_label(const Curve& curve, const BudgetPoint& point) {
    std::string text = spoken_budget(curve.budget_kind, point.budget);
    text += ": " + percent_text(point.relative.value);
    if (!std::isnan(point.relative.low))
        text += " [" + plain_number(point.relative.low * 100) + ", " + plain_number(point.relative.high * 100) + "]";
    text += " in " + duration_text(point.cpu_seconds) + " CPU, " + duration_text(point.wall_seconds) + " wall, " +
            std::to_string(point.group.errors.size()) + (point.group.errors.size() == 1 ? " replicate" : " replicates");
    if (!point.relative.note.empty()) text += "\n" + point.relative.note;
    return text;
}

Json plot_number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

std::size_t slot_of(const Study& study, const std::string& variant) {
    const auto found = std::find_if(study.variants.begin(), study.variants.end(),
                                    [&](const MethodVariant& each) { return each.name == variant; });
    return static_cast<std::size_t>(found - study.variants.begin());
}

enum class Abscissa { seconds, samples };

/// Returns the slope of the squared error, as in the page's table.
std::string slope_note(const Curve& curve) {
    const std::optional<Line>& line = curve.slope.checked();
    if (!line) return {};
    return "error\u00b2 falls with slope " + number_text(line->slope, 3) + " [" + number_text(line->slope_low, 3) +
           ", " + number_text(line->slope_high, 3) + "]";
}

Json series_of(const Study& study, const Curve& curve, Abscissa against = Abscissa::seconds) {
    Json points = Json::array();
    std::vector<BudgetPoint> ordered = curve.points;
    if (against == Abscissa::samples) {
        std::erase_if(ordered, [](const BudgetPoint& point) { return !(point.samples > 0); });
        std::stable_sort(ordered.begin(), ordered.end(),
                         [](const BudgetPoint& a, const BudgetPoint& b) { return a.samples < b.samples; });
    }
    for (const BudgetPoint& point : ordered)
        points.push_back(Json{{"x", plot_number(against == Abscissa::seconds ? point.seconds : point.samples)},
                              {"y", plot_number(point.relative.value * 100)},
                              {"low", plot_number(point.relative.low * 100)},
                              {"high", plot_number(point.relative.high * 100)},
                              {"weak", !point.relative.valid()},
                              {"label", budget_label(curve, point)}});
    return Json{{"name", curve.variant},
                {"slot", slot_of(study, curve.variant)},
                {"note", slope_note(curve)},
                {"points", std::move(points)}};
}

std::string dumped(const Json& json) {
    return json_text(json);
}

std::string time_label(const Study& study) {
    return std::string(study.experiment->cpu_clock ? "CPU" : "wall") + " time, seconds, everything counted";
}

Plot error_plot(const Study& study, std::size_t scene, const std::string& channel, const std::string& region,
                Abscissa against) {
    const std::string& name = study.experiment->scenes[scene].name;
    const bool time = against == Abscissa::seconds;
    Plot plot{time ? plot_id(scene, channel, region) : samples_id(scene, channel, region),
              file_part(name) + "." + file_part(channel),
              {}};
    if (!region.empty()) plot.file += "." + file_part(region);
    plot.file += time ? ".svg" : ".samples.svg";
    Json series = Json::array();
    double floor = 0;
    std::set<double> budgets;  // positions of the budgets if the axis has samples
    for (const Curve& curve : study.curves) {
        if (curve.scene != name || curve.channel != channel || curve.region != region) continue;
        if (curve.budget_kind == (time ? BudgetKind::seconds : BudgetKind::samples))
            for (const BudgetPoint& point : curve.points) budgets.insert(point.budget);
        series.push_back(series_of(study, curve, against));
        for (const BudgetPoint& point : curve.points)
            floor = std::max(floor, std::sqrt(std::max(0.0, point.excess)) * 100);
    }
    plot.json = dumped(
        Json{{"id", plot.id},
             {"title", name + ", " + channel + (region.empty() ? "" : ", region " + region) +
                           (time ? ": error against time" : ": error against samples")},
             {"subtitle", std::string("100 sqrt(relmse-mean)") +
                              (study.noise_subtracted(name, channel, region) ? ", reference's noise subtracted" : "") +
                              "; bands: " + number_text(study.options.confidence * 100) +
                              (time ? " % intervals; dotted: 1/sqrt(t)" : " % intervals; dotted: 1/sqrt(n)")},
             {"xLabel", time ? time_label(study) : "samples per pixel"},
             {"yLabel", "relative error"},
             {"guide", true},
             {"ticks", budgets},
             {"floor", floor},
             {"series", std::move(series)}});
    return plot;
}

/// Renderers by command line do not report their number of samples.
bool any_samples(const Study& study, const Curve& like) {
    return std::any_of(study.curves.begin(), study.curves.end(), [&](const Curve& curve) {
        return curve.scene == like.scene && curve.channel == like.channel && curve.region == like.region &&
               std::any_of(curve.points.begin(), curve.points.end(),
                           [](const BudgetPoint& p) { return p.samples > 0; });
    });
}

Plot front_plot(const Study& study, std::size_t scene, const std::string& channel) {
    const std::string& name = study.experiment->scenes[scene].name;
    Json series = Json::array(), front = Json::array();
    for (const Curve& curve : study.curves)
        if (curve.scene == name && curve.channel == channel && curve.region.empty()) {
            Json one = series_of(study, curve);
            one["note"] = "";
            series.push_back(std::move(one));
        }
    for (const FrontPoint& each : front_of(study, name, channel))
        front.push_back(Json{{"x", each.point->seconds}, {"y", each.point->relative.value * 100}});
    Plot plot{front_id(scene, channel), file_part(name) + "." + file_part(channel) + ".pareto.svg", {}};
    plot.json = dumped(
        Json{{"id", plot.id},
             {"title", name + ", " + channel + ": Pareto front of error and time"},
             {"subtitle",
              "every variant at every budget; the line joins the points that no other beats in both time and error"},
             {"xLabel", time_label(study)},
             {"yLabel", "relative error"},
             {"scatter", true},
             {"floor", 0},
             {"series", std::move(series)},
             {"front", std::move(front)}});
    return plot;
}

Plot spectrum_plot(const Study& study, std::size_t scene, const std::string& channel) {
    const std::string& name = study.experiment->scenes[scene].name;
    Json series = Json::array();
    double floor = 0;
    for (const ErrorSpectrum& spectrum : study.spectra) {
        if (spectrum.curve->scene != name || spectrum.curve->channel != channel) continue;
        Json points = Json::array();
        for (const auto& [frequency, mean, least, most] : spectrum.points) {
            const double error = std::sqrt(mean), low = std::sqrt(least), high = std::sqrt(most);
            points.push_back(
                Json{{"x", frequency},
                     {"y", 100 * error},
                     {"low", 100 * low},
                     {"high", 100 * high},
                     {"label", plain_number(frequency) + " cycles per pixel: " + percent_text(error) + " [" +
                                   plain_number(100 * low) + ", " + plain_number(100 * high) + "]"}});
        }
        floor = std::max(floor, 100 * spectrum.reference_error);
        points.erase(points.begin());  // a logarithmic axis has no place for frequency 0
        series.push_back(Json{{"name", spectrum.curve->variant},
                              {"slot", slot_of(study, spectrum.curve->variant)},
                              {"note", budget_label(*spectrum.curve, spectrum.curve->points.back())},
                              {"points", std::move(points)}});
    }
    Plot plot{spectrum_id(scene, channel), file_part(name) + "." + file_part(channel) + ".spectrum.svg", {}};
    plot.json =
        dumped(Json{{"id", plot.id},
                    {"title", name + ", " + channel + ": error by spatial frequency"},
                    {"subtitle", "100 sqrt(mean power of a - b) / mean(|b|); bands: least to largest replicate"},
                    {"xLabel", "cycles per pixel"},
                    {"yLabel", "relative error at this frequency"},
                    {"floor", floor},
                    {"series", std::move(series)}});
    return plot;
}

}  // namespace

std::string file_part(const std::string& name) {
    std::string result;
    for (const char c : name) {
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
        result += plain ? c : '_';
    }
    return result;
}

std::string plot_id(std::size_t scene, const std::string& channel, const std::string& region) {
    return "s" + std::to_string(scene) + "-" + file_part(channel) + (region.empty() ? "" : "-at-" + file_part(region));
}

std::string samples_id(std::size_t scene, const std::string& channel, const std::string& region) {
    return plot_id(scene, channel, region) + "--samples";
}

std::string front_id(std::size_t scene, const std::string& channel) {
    return "s" + std::to_string(scene) + "-" + file_part(channel) + "--front";
}

std::string spectrum_id(std::size_t scene, const std::string& channel) {
    return plot_id(scene, channel, "") + "--spectrum";
}

std::vector<FrontPoint> front_of(const Study& study, const std::string& scene, const std::string& channel) {
    std::vector<FrontPoint> points, front;
    std::vector<CostPoint> costs;
    for (const Curve& curve : study.curves)
        if (curve.scene == scene && curve.channel == channel && curve.region.empty())
            for (const BudgetPoint& point : curve.points)
                if (point.relative.value > 0) {
                    points.push_back({&curve, &point});
                    costs.push_back({point.seconds, point.relative.value});
                }
    for (const std::size_t i : pareto_front(costs)) front.push_back(points[i]);
    return front;
}

std::vector<Plot> plots_of(const Study& study) {
    std::vector<Plot> plots;
    for (std::size_t s = 0; s < study.experiment->scenes.size(); ++s) {
        const SceneInfo& scene = study.experiment->scenes[s];
        std::vector<std::pair<std::string, std::string>> seen;
        for (const Curve& curve : study.curves)
            if (curve.scene == scene.name &&
                std::find(seen.begin(), seen.end(), std::pair(curve.channel, curve.region)) == seen.end()) {
                seen.emplace_back(curve.channel, curve.region);
                plots.push_back(error_plot(study, s, curve.channel, curve.region, Abscissa::seconds));
                if (any_samples(study, curve))
                    plots.push_back(error_plot(study, s, curve.channel, curve.region, Abscissa::samples));
                if (!curve.region.empty()) continue;
                plots.push_back(front_plot(study, s, curve.channel));
                plots.push_back(spectrum_plot(study, s, curve.channel));
            }
        if (auto costs = effect_costs_plot(study, s)) plots.push_back(*std::move(costs));
    }
    return plots;
}

}  // namespace raylex::experiments
