// Verdicts over the curves of a study: slopes, times, speed-ups, what a setting buys, which paths are wrong.
#include <algorithm>
#include <cmath>

#include "experiments/study/report/study.h"

namespace raylex::experiments {
namespace {

std::vector<BudgetGroup> groups_of(const Curve& curve) {
    std::vector<BudgetGroup> groups;
    for (const BudgetPoint& point : curve.points) groups.push_back(point.group);
    return groups;
}

/// The most expensive point whose error stands clear of the reference's own; the most expensive one when none does.
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

std::string others_of(const MethodVariant& variant, const std::string& key) {
    std::string text = variant.method;
    for (const auto& [name, value] : variant.settings)
        if (name != key) text += " " + name + "=" + value;
    return text;
}

const std::string* setting(const MethodVariant& variant, const std::string& key) {
    for (const auto& [name, value] : variant.settings)
        if (name == key) return &value;
    return nullptr;
}

void find_effects(Study& study, const SceneInfo& scene) {
    if (scene.channels.empty()) return;
    const std::string& channel = scene.channels.front().name;
    // Each value of a key against the first value that stands with the same others.
    for (std::size_t j = 1; j < study.variants.size(); ++j)
        for (const auto& [key, value] : study.variants[j].settings) {
            const MethodVariant &to = study.variants[j], *from = nullptr;
            for (std::size_t i = 0; i < j && from == nullptr; ++i)
                if (others_of(study.variants[i], key) == others_of(to, key) &&
                    setting(study.variants[i], key) != nullptr)
                    from = &study.variants[i];
            if (from == nullptr) continue;
            const Curve *a = study.curve(scene.name, to.name, channel),
                        *b = study.curve(scene.name, from->name, channel);
            if (a == nullptr || b == nullptr) continue;
            study.effects.push_back({scene.name, key, *setting(*from, key), value, others_of(to, key),
                                     speed_up(*a, *b, study.options.confidence)});
        }
}

void find_words(Study& study, const SceneInfo& scene, const MethodVariant& variant) {
    std::vector<JudgedChannel> channels;
    bool any = false;
    for (const BiasEntry& entry : study.bias) {
        if (entry.scene != scene.name || entry.variant != variant.name || !entry.verdict.tested) continue;
        any = any || entry.convicts();
        for (const ChannelInfo& channel : scene.channels)
            if (channel.name == entry.channel && !channel.beauty)
                channels.push_back({channel.name, channel.expression, channel.dialect, entry.convicts(),
                                    entry.verdict.adjusted_p});
    }
    if (!any) return;
    WordsEntry entry{scene.name, variant.name, first_differing_words(channels)};
    if (entry.first.words.empty() && entry.first.notes.empty())
        entry.first.notes.emplace_back(
            "no channel but the beauty differs; channels by bounce "
            "(`raylex lpe split --by bounce,lobe`) would tell which paths do");
    study.words.push_back(std::move(entry));
}

}  // namespace

void judge_curves(Study& study) {
    for (BiasEntry& entry : study.bias)
        if (const Curve* curve = study.curve(entry.scene, entry.variant, entry.channel))
            for (const BudgetPoint& point : curve->points)
                if (point.budget == entry.budget) entry.heavy_tail = point.group.heavy_tail;
    for (Curve& curve : study.curves) {
        std::stable_sort(curve.points.begin(), curve.points.end(),
                         [](const BudgetPoint& a, const BudgetPoint& b) { return a.seconds < b.seconds; });
        const std::vector<BudgetGroup> groups = groups_of(curve);
        bool unbiased = true;
        for (const MethodVariant& variant : study.variants)
            if (variant.name == curve.variant) unbiased = variant.unbiased;
        curve.slope = judge_slope(groups, unbiased);
        for (const double target : target_errors)
            curve.times.push_back(time_to_error(groups, target, study.options.confidence));
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
        for (const MethodVariant& variant : study.variants) find_words(study, scene, variant);
    }
}

}  // namespace raylex::experiments
