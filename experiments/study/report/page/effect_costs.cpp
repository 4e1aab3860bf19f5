#include "experiments/study/report/page/effect_costs.h"

#include <algorithm>
#include <cmath>

#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/study/report/page/study_tables.h"

namespace raylex::experiments {
namespace {

constexpr std::string_view effect_prefix = "effects.";
constexpr const char* caveat_sign = "&lowast;";

const std::string& beauty_of(const Study& study, const std::string& scene) {
    static const std::string none;
    for (const SceneInfo& each : study.experiment->scenes)
        for (const ChannelInfo& channel : each.channels)
            if (each.name == scene && channel.beauty) return channel.name;
    return none;
}

/// Returns the CPU seconds of each replicate at a budget.
std::vector<double> cpu_seconds(const Study& study, const Curve& curve, double budget) {
    std::vector<double> seconds;
    for (const RunErrors& each : study.runs)
        if (each.run->scene == curve.scene && each.variant == curve.variant && each.channel == curve.channel &&
            each.region.empty() && each.run->budget == budget)
            seconds.push_back(each.run->cpu_seconds);
    return seconds;
}

/// Returns the points of the largest budget that both curves have; null if there is none.
std::pair<const BudgetPoint*, const BudgetPoint*> last_common(const Curve& a, const Curve& b) {
    std::pair<const BudgetPoint*, const BudgetPoint*> found{nullptr, nullptr};
    for (const BudgetPoint& x : a.points)
        for (const BudgetPoint& y : b.points)
            if (x.budget == y.budget && (found.first == nullptr || x.budget > found.first->budget)) found = {&x, &y};
    return found;
}

std::string percent_cell(const Interval& interval) {
    if (!std::isfinite(interval.value)) return "<td class=\"number\">&ndash;</td>";
    std::string text = plain_number(interval.value * 100) + " %";
    if (!interval.valid())
        text += "<sup class=\"sign\" title=\"" + escape_html(interval.note) + "\">" + caveat_sign + "</sup>";
    if (std::isfinite(interval.low) && std::isfinite(interval.high))
        text += " <span class=\"range\">[" + plain_number(interval.low * 100) + ", " +
                plain_number(interval.high * 100) + "]</span>";
    return "<td class=\"number\">" + text + "</td>";
}

Json effect_point(const EffectCost& cost, const Interval& error, double time, const std::string& name,
                  std::size_t slot) {
    const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
    const std::string label = name + ": " + percent_text(error.value) + " in " + plain_number(time * 100) +
                              " % of the CPU time of " + cost.against;
    return Json{{"name", name},
                {"slot", slot},
                {"note", ""},
                {"points", Json::array({Json{{"x", number(time * 100)},
                                             {"y", number(error.value * 100)},
                                             {"low", number(error.low * 100)},
                                             {"high", number(error.high * 100)},
                                             {"weak", !error.valid()},
                                             {"label", label}}})}};
}

}  // namespace

std::vector<EffectCost> effect_costs(const Study& study, const std::string& scene) {
    std::vector<EffectCost> costs;
    const std::string& beauty = beauty_of(study, scene);
    for (const SettingEffect& each : study.effects) {
        if (each.scene != scene || each.channel != beauty || !each.key.starts_with(effect_prefix) ||
            each.from != "default")
            continue;
        const Curve *to = study.curve(scene, each.variant, beauty), *from = study.curve(scene, each.against, beauty);
        if (to == nullptr || from == nullptr) continue;
        const auto [with, without] = last_common(*to, *from);
        if (with == nullptr) continue;
        const std::vector<double> mine = cpu_seconds(study, *to, with->budget),
                                  whole = cpu_seconds(study, *from, with->budget);
        const std::vector<std::vector<Factor>> ratio{{{mine, 1}}, {{whole, -1}}};
        IntervalOptions options;
        options.confidence = study.options.confidence;
        costs.push_back({each.key.substr(effect_prefix.size()), each.variant, each.against, each.to == "on",
                         product_interval(ratio, options), with->relative, without->relative});
    }
    return costs;
}

std::string effect_costs_table(const Study& study, const std::string& scene) {
    std::string rows, caveats;
    for (const EffectCost& each : effect_costs(study, scene)) {
        for (const Interval* interval : {&each.time, &each.error, &each.own_error})
            if (!interval->valid() && caveats.find(interval->note) == std::string::npos)
                caveats += (caveats.empty() ? "" : "; ") + interval->note;
        rows += "<tr>" + text_cell(each.effect) + text_cell(each.on ? "forced on" : "left out") +
                percent_cell(each.time) + percent_cell(each.error) + percent_cell(each.own_error) + "</tr>\n";
    }
    if (rows.empty()) return {};
    return "<p class=\"note\">CPU time: relative to the method that differs only in this effect, "
           "at equal samples. Error: 100 sqrt(relmse-mean) against the reference, which has every effect, noise "
           "included: "
           "the whole render's own is all noise, and a scene that lacks an effect may have less of it. Forced on where "
           "the "
           "scene has none, the image is the same but for the seed: what the time is beyond 100 %, the effect's "
           "absence "
           "saves.</p>\n" +
           table("<th>Effect</th><th></th><th>CPU time</th><th>Error</th><th>The whole render's own</th>", rows) +
           (caveats.empty()
                ? ""
                : "<p class=\"note\"><sup>" + std::string(caveat_sign) + "</sup> " + escape_html(caveats) + ".</p>\n");
}

std::optional<Plot> effect_costs_plot(const Study& study, std::size_t scene) {
    const std::string& name = study.experiment->scenes[scene].name;
    const std::vector<EffectCost> costs = effect_costs(study, name);
    Json series = Json::array();
    const auto slot = [&](const std::string& variant) {
        const auto found = std::find_if(study.variants.begin(), study.variants.end(),
                                        [&](const MethodVariant& each) { return each.name == variant; });
        return static_cast<std::size_t>(found - study.variants.begin());
    };
    for (const EffectCost& each : costs) {
        if (series.empty()) series.push_back(effect_point(each, each.own_error, 1, each.against, slot(each.against)));
        series.push_back(effect_point(each, each.error, each.time.value, each.variant, slot(each.variant)));
    }
    if (costs.empty()) return std::nullopt;
    Plot plot{effect_costs_id(scene), file_part(name) + ".effects.svg", {}};
    plot.json = json_text(Json{{"id", plot.id},
                               {"title", name + ": what accuracy costs in time, per effect"},
                               {"subtitle", "error and time of a render without one effect"},
                               {"xLabel", "CPU time, per cent of the whole render's"},
                               {"yLabel", "relative error"},
                               {"scatter", true},
                               {"floor", 0},
                               {"series", std::move(series)}});
    return plot;
}

std::string effect_costs_id(std::size_t scene) {
    return "s" + std::to_string(scene) + "--effects";
}

}  // namespace raylex::experiments
