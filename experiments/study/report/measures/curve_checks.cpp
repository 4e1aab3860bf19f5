// Computes slopes, times, speed-ups, effects of settings and wrong paths from the curves of a study.
#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/program/console.h"
#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"

namespace raylex::experiments {
namespace {

std::vector<BudgetGroup> groups_of(const Curve& curve) {
    std::vector<BudgetGroup> groups;
    for (const BudgetPoint& point : curve.points) groups.push_back(point.group);
    return groups;
}

/// Returns the largest budget whose error is clearly above the reference's own; if there is none, the largest budget.
const BudgetPoint* best_point(const Curve& curve) {
    const BudgetPoint* best = nullptr;
    for (const BudgetPoint& point : curve.points)
        if (!point.group.at_floor) best = &point;
    return best != nullptr || curve.points.empty() ? best : &curve.points.back();
}

Interval speed_up(const Curve& curve, const Curve& against, double confidence) {
    const BudgetPoint *a = best_point(curve), *b = best_point(against);
    if (a == nullptr || b == nullptr) {
        Interval none{NAN, NAN, NAN, "not measured", {}};
        return none;
    }
    IntervalOptions options;
    options.confidence = confidence;
    Interval result =
        speed_up_interval({a->group.errors, a->group.seconds}, {b->group.errors, b->group.seconds}, options);
    for (const BudgetPoint* each : {a, b})
        if (result.valid() && !each->squared.valid()) result.note = each->squared.note;
    return result;
}

/// Returns the median of error x time over replicates; NaN if there are none.
double median_cost(const BudgetPoint& point) {
    std::vector<double> costs;
    for (std::size_t i = 0; i < point.group.errors.size(); ++i)
        costs.push_back(point.group.errors[i] * point.group.seconds[i]);
    if (costs.empty()) return NAN;
    std::sort(costs.begin(), costs.end());
    const std::size_t middle = costs.size() / 2;
    return costs.size() % 2 == 1 ? costs[middle] : (costs[middle - 1] + costs[middle]) / 2;
}

/// A few fireflies change the mean of replicates and invalidate its interval, but do not change the median.
double speed_up_by_medians(const Curve& curve, const Curve& against) {
    const BudgetPoint *a = best_point(curve), *b = best_point(against);
    if (a == nullptr || b == nullptr) return NAN;
    const double cost = median_cost(*a), against_cost = median_cost(*b);
    return cost > 0 && against_cost > 0 ? against_cost / cost : NAN;  // not above 0: at the reference's own error
}

std::string others_of(const MethodVariant& variant, const std::string& key) {
    std::string text = variant.method;
    for (const auto& [name, value] : variant.settings)
        if (name != key) text += " " + name + "=" + value;
    return text;
}

/// Returns a variant's value of a setting, or "default".
const std::string& setting(const MethodVariant& variant, const std::string& key) {
    static const std::string unsaid = "default";
    for (const auto& [name, value] : variant.all_settings)
        if (name == key) return value;
    return unsaid;
}

/// Returns the only setting in which two variants differ; empty if there are several or none.
std::string only_difference(const MethodVariant& a, const MethodVariant& b) {
    std::set<std::string> keys;
    for (const MethodVariant* each : {&a, &b})
        for (const auto& [key, value] : each->all_settings) keys.insert(key);
    // With and without a filter counts as one difference, in the type, whatever the parameters.
    for (const char* entity : {"integrator", "sampler", "filter", "sample_filter"}) {
        const std::string prefix = std::string(entity) + ".", type = prefix + "type";
        if (setting(a, type) == setting(b, type)) continue;
        std::erase_if(keys, [&](const std::string& key) { return key.starts_with(prefix) && key != type; });
    }
    std::erase_if(keys, [&](const std::string& key) { return setting(a, key) == setting(b, key); });
    return keys.size() == 1 ? *keys.begin() : std::string();
}

/// Returns a setting's value as text; of a filter, sampler or integrator with its parameters.
std::string setting_text(const MethodVariant& variant, const std::string& key) {
    std::string text = setting(variant, key), parameters;
    if (!key.ends_with(".type")) return text;
    const std::string prefix = key.substr(0, key.size() - 4);
    if (prefix == "sample_filter." && text == "default") return "none";
    for (const auto& [name, value] : variant.all_settings)
        if (name.starts_with(prefix) && name != key)
            parameters += (parameters.empty() ? "" : ", ") + name.substr(prefix.size()) + "=" + value;
    return parameters.empty() ? text : text + " (" + parameters + ")";
}

/// Returns the change between two variants. Two methods are named, with the setting in which they differ.
SettingEffect change_between(const MethodVariant& from, const MethodVariant& to, const std::string& key) {
    const std::string before = setting_text(from, key), after = setting_text(to, key);
    if (from.method == to.method || key.starts_with("effects."))
        return {.key = key, .from = before, .to = after, .others = others_of(from, key)};
    std::string others = key == "command" ? "another renderer" : key + " " + before + " to " + after;
    for (const auto& [name, value] : from.settings)
        if (name != key) others += ", " + name + "=" + value;
    return {.key = "method", .from = from.method, .to = to.method, .others = others};
}

/// Compares each variant with the first earlier one that differs in exactly one setting, for each setting.
void find_effects(Study& study, const SceneInfo& scene) {
    for (std::size_t j = 1; j < study.variants.size(); ++j) {
        const MethodVariant& to = study.variants[j];
        std::set<std::string> seen;
        for (std::size_t i = 0; i < j; ++i) {
            const MethodVariant& from = study.variants[i];
            const std::string key = only_difference(from, to);
            if (key.empty() || !seen.insert(key).second) continue;
            for (const ChannelInfo& channel : scene.channels) {
                const Curve *a = study.curve(scene.name, to.name, channel.name),
                            *b = study.curve(scene.name, from.name, channel.name);
                if (a == nullptr || b == nullptr) continue;
                SettingEffect& effect = study.effects.emplace_back(change_between(from, to, key));
                effect.scene = scene.name;
                effect.channel = channel.name;
                effect.variant = to.name;
                effect.against = from.name;
                effect.speed_up = speed_up(*a, *b, study.options.confidence);
                effect.by_medians = speed_up_by_medians(*a, *b);
            }
        }
    }
}

void add_counterexamples(Study& study, const SceneInfo& scene, const MethodVariant& variant) {
    std::vector<TestedChannel> channels;
    bool any = false;
    for (const BiasEntry& entry : study.bias) {
        // A channel with an uncertain result is neither wrong nor right.
        if (entry.scene != scene.name || entry.variant != variant.name ||
            (!entry.convicts() && entry.conclusion() != BiasConclusion::none_found))
            continue;
        any = any || entry.convicts();
        for (const ChannelInfo& channel : scene.channels)
            if (channel.name == entry.channel && !channel.beauty)
                channels.push_back(
                    {channel.name, channel.expression, channel.dialect, entry.convicts(), entry.result.adjusted_p});
    }
    if (!any) return;
    CounterexampleEntry entry{scene.name, variant.name, find_counterexamples(channels)};
    if (entry.first.words.empty() && entry.first.notes.empty())
        entry.first.notes.emplace_back(
            "only the beauty differs; channels by bounce (`raylex lpe split --by bounce,lobe`) would show which paths "
            "differ");
    study.words.push_back(std::move(entry));
}

/// Removes extrapolated times, because a bias or missing paths make extrapolation impossible.
void stop_at_measured(Curve& curve, const std::string& reason) {
    const auto least = std::min_element(
        curve.points.begin(), curve.points.end(),
        [](const BudgetPoint& a, const BudgetPoint& b) { return a.relative.value < b.relative.value; });
    for (TimeToError& time : curve.times)
        if (time.extrapolated && least != curve.points.end() && time.relative_error < least->relative.value)
            time.seconds = {NAN,
                            NAN,
                            NAN,
                            "not followed beyond " + percent_text(least->relative.value) + " after " +
                                duration_text(least->seconds) + ", because it " + reason,
                            {}};
}

}  // namespace

void check_curves(Study& study) {
    for (BiasEntry& entry : study.bias)
        for (const std::string& side : {entry.variant, entry.against})
            if (const Curve* curve = study.curve(entry.scene, side, entry.channel))
                for (const BudgetPoint& point : curve->points)
                    if (point.budget == entry.budget) entry.heavy_tail = entry.heavy_tail || point.group.heavy_tail;
    for (Curve& curve : study.curves) {
        std::stable_sort(curve.points.begin(), curve.points.end(),
                         [](const BudgetPoint& a, const BudgetPoint& b) { return a.seconds < b.seconds; });
        const std::vector<BudgetGroup> groups = groups_of(curve);
        curve.slope = test_slope(groups, study.unbiased(curve.variant));
        for (const double target : target_errors)
            curve.times.push_back(time_to_error(groups, target, study.options.confidence));
        for (const BiasEntry& entry : study.bias)
            if (entry.scene == curve.scene && entry.variant == curve.variant && entry.channel == curve.channel) {
                if (!entry.omitted.empty()) stop_at_measured(curve, "does not find " + entry.omitted);
                else if (entry.convicts()) stop_at_measured(curve, "differs by " + finding_of(study, entry));
                if (!entry.omitted.empty()) {
                    curve.slope.too_shallow = curve.slope.nears = false;
                    curve.slope.text = "not judged: it declares that it does not find " + entry.omitted;
                } else if (curve.slope.too_shallow && entry.convicts()) {
                    curve.slope.too_shallow = false;  // counted once, among the findings about bias
                    curve.slope.text = "shallower than -1, as expected from the bias found here";
                } else if (curve.slope.too_shallow && !entry.caveat.empty()) {
                    curve.slope.too_shallow = false;  // an error of the reference flattens curves, too
                    curve.slope.text = "shallower than -1, as an error of the reference would cause";
                }
            }
        curve.prediction = check_prediction(groups);
    }
    for (Curve& curve : study.curves)
        for (const MethodVariant& variant : study.variants)
            if (const Curve* base = study.curve(curve.scene, variant.name, curve.channel, curve.region);
                base != nullptr) {
                curve.first = base == &curve;
                curve.speed_up = speed_up(curve, *base, study.options.confidence);
                break;
            }
    for (const SceneInfo& scene : study.experiment->scenes) {
        find_effects(study, scene);
        for (const MethodVariant& variant : study.variants) add_counterexamples(study, scene, variant);
    }
}

}  // namespace raylex::experiments
