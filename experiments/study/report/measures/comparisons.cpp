// Finds the best method for each channel at a time that all methods reached. Also texts of bias verdicts.
#include <algorithm>
#include <cmath>

#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"

namespace raylex::experiments {
namespace {

/// Returns the points with an error above 0, by seconds.
std::vector<const BudgetPoint*> known_points(const Curve& curve) {
    std::vector<const BudgetPoint*> points;
    for (const BudgetPoint& point : curve.points)
        if (point.squared.value > 0 && point.seconds > 0) points.push_back(&point);
    return points;
}

/// Interpolates linearly in logarithms between two budgets. The ends of the interval are interpolated too, so the
/// interval is rather too wide.
Interval between(const Interval& a, const Interval& b, double share) {
    const auto mixed = [share](double x, double y) {
        return std::exp((1 - share) * std::log(std::max(x, 0.0)) + share * std::log(std::max(y, 0.0)));
    };
    const auto end = [&](double x, double y) { return std::isnan(x) || std::isnan(y) ? NAN : mixed(x, y); };
    return {mixed(a.value, b.value), end(a.low, b.low), end(a.high, b.high), a.note.empty() ? b.note : a.note, {}};
}

Standing standing_at(const Curve& curve, double seconds) {
    constexpr double clock = 0.05;  // times of two renders with equal budgets of seconds differ by up to this fraction
    const std::vector<const BudgetPoint*> points = known_points(curve);
    const auto after = std::find_if(points.begin(), points.end(),
                                    [seconds](const BudgetPoint* point) { return point->seconds >= seconds; });
    if (after != points.begin() && after != points.end()) {
        const BudgetPoint &a = **(after - 1), &b = **after;
        return {&curve, between(a.squared, b.squared, std::log(seconds / a.seconds) / std::log(b.seconds / a.seconds))};
    }
    const BudgetPoint& nearest = after == points.end() ? *points.back() : **after;
    const double factor = nearest.seconds / seconds;
    Standing standing{&curve, nearest.squared, std::abs(std::log(factor)) > clock};
    for (double* each : {&standing.squared.value, &standing.squared.low, &standing.squared.high}) *each *= factor;
    return standing;
}

/// Returns the ratio of independent estimates. The intervals of their logarithms are combined as in Zou and Donner
/// (Statistics in Medicine 27, 2008).
Interval ratio_of(const Interval& a, const Interval& b) {
    const auto distance = [](double x, double y) { return std::log(x) - std::log(std::max(y, 0.0)); };
    const double below = std::hypot(distance(a.value, a.low), distance(b.high, b.value)),
                 above = std::hypot(distance(a.high, a.value), distance(b.value, b.low));
    const double value = a.value / b.value;
    if (below + above > std::log(widest_ratio)) return {NAN, NAN, NAN, wide_note, {}};
    return {value, value * std::exp(-below), value * std::exp(above), a.note.empty() ? b.note : a.note, {}};
}

MethodComparison comparison_of(const Study& study, const std::string& scene, const std::string& channel) {
    MethodComparison result;
    result.scene = scene;
    result.channel = channel;
    result.seconds = std::numeric_limits<double>::infinity();
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < study.variants.size(); ++i) {
        const Curve* curve = study.curve(scene, study.variants[i].name, channel);
        result.standings.push_back({curve, {NAN, NAN, NAN, {}, {}}});
        if (curve == nullptr || known_points(*curve).empty()) continue;
        order.push_back(i);
        result.seconds = std::min(result.seconds, known_points(*curve).back()->seconds);
    }
    result.measured = order.size();
    for (const std::size_t i : order) result.standings[i] = standing_at(*result.standings[i].curve, result.seconds);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return result.standings[a].squared.value < result.standings[b].squared.value;
    });
    if (!order.empty()) result.best = order[0];
    if (order.size() < 2) return result;
    result.second = order[1];
    result.ratio = ratio_of(result.standings[order[1]].squared, result.standings[order[0]].squared);
    return result;
}

std::string signed_percent(const Interval& share) {
    if (!std::isfinite(share.value)) return "light where the reference has none";
    std::string text = (share.value > 0 ? "+" : "") + percent_text(share.value);
    if (std::isfinite(share.low) && std::isfinite(share.high))
        text += " [" + plain_number(share.low * 100) + ", " + plain_number(share.high * 100) + "]";
    return text;
}

}  // namespace

void compare_variants(Study& study) {
    for (const SceneInfo& scene : study.experiment->scenes)
        for (const ChannelInfo& channel : scene.channels)
            if (MethodComparison each = comparison_of(study, scene.name, channel.name); each.measured > 0)
                study.comparisons.push_back(std::move(each));
}

std::string best_sentence(const Study& study, const MethodComparison& comparison) {
    const std::string &best = study.variants[comparison.best].name, &second = study.variants[comparison.second].name;
    const Interval& ratio = comparison.ratio;
    const std::string range =
        std::isfinite(ratio.low) ? " [" + plain_number(ratio.low) + ", " + plain_number(ratio.high) + "]" : "";
    if (comparison.measured == 1) return "only " + best + " was measured for " + comparison.channel;
    if (!std::isfinite(ratio.value))
        return "no method is ahead for " + comparison.channel + ": the interval of " + second + " over " + best +
               " spans more than a factor of 100";
    const std::string before = ": " + plain_number(ratio.value) + " times" + range + " before " + second;
    if (!ratio.valid()) return best + " seems best for " + comparison.channel + before + ", but " + ratio.note;
    if (ratio.low <= 1)
        return "no method is certainly ahead for " + comparison.channel + ": " + best + before.substr(1);
    return best + " for " + comparison.channel + ": " + plain_number(ratio.value) +
           " times less squared error in the same time than " + second + range;
}

BiasConclusion BiasEntry::conclusion() const {
    if (!result.tested) return BiasConclusion::not_tested;
    if (!omitted.empty()) return BiasConclusion::omits_paths;
    if (result.differs && heavy_tail) return BiasConclusion::rare;
    if (result.differs && caveat.empty()) return BiasConclusion::differs;
    const bool told = reason().empty() && result.detectable_whole <= largest_hidden_bias;
    return told ? BiasConclusion::none_found : BiasConclusion::cannot_tell;
}

std::string finding_of(const Study& study, const BiasEntry& entry) {
    const BiasTest& v = entry.result;
    const std::string mean = signed_percent(v.mean_difference) + " of the mean";
    if (v.worst_is_whole || v.mean_difference.low > 0 || v.mean_difference.high < 0) return mean;
    return signed_percent(v.worst_difference) + " in the " + block_text(study, entry) + ", " + mean;
}

std::string block_text(const Study& study, const BiasEntry& entry) {
    if (entry.result.worst_is_whole) return "whole image";
    std::size_t across = 1;
    for (const SceneInfo& scene : study.experiment->scenes)
        if (scene.name == entry.scene) across = block_count(static_cast<std::size_t>(scene.width), 1);
    const auto pixel = [](std::size_t block) { return std::to_string(block * bias_block); };
    return "block at (" + pixel(entry.result.worst % across) + ", " + pixel(entry.result.worst / across) + ")";
}

std::string result_of(const Study& study, const BiasEntry& entry) {
    const double detectable = entry.result.detectable_whole;
    switch (entry.conclusion()) {
        case BiasConclusion::not_tested:
            return "not tested: " + entry.result.note;
        case BiasConclusion::omits_paths:
            return "not judged: the method declares that it does not find " + entry.omitted;
        case BiasConclusion::rare:
            return "differs, but a few rare samples dominate: " + finding_of(study, entry);
        case BiasConclusion::differs:
            return (study.unbiased(entry.variant) ? "differs: " : "differs, as declared: ") + finding_of(study, entry);
        case BiasConclusion::none_found:
            return "no bias found";
        case BiasConclusion::cannot_tell:
            break;
    }
    return "cannot tell: " +
           (!entry.caveat.empty()         ? entry.caveat + (entry.result.differs ? ": " + finding_of(study, entry) : "")
            : !entry.result.blind.empty() ? "differs in the " + block_text(study, entry) + ", but " + entry.result.blind
            : !std::isfinite(detectable)  ? "the mean of the image could not be tested"
                                         : "a bias below " + percent_text(detectable) + " of the mean would be missed");
}

const Counterexamples::Counterexample* first_counterexample(const Study& study, const std::string& scene,
                                                            const std::string& variant) {
    const auto named = std::find_if(study.bias.begin(), study.bias.end(), [&](const BiasEntry& each) {
        return each.scene == scene && each.variant == variant && each.convicts();
    });
    if (named == study.bias.end()) return nullptr;
    bool any = false;
    for (const SceneInfo& each : study.experiment->scenes)
        for (const ChannelInfo& channel : each.channels)
            any = any || (each.name == scene && channel.name == named->channel && channel.beauty);
    for (const CounterexampleEntry& entry : study.words)
        if (entry.scene == scene && entry.variant == variant)
            for (const Counterexamples::Counterexample& word : entry.first.words)
                if (any || word.channel == named->channel) return &word;
    return nullptr;
}

bool Study::unbiased(const std::string& variant) const {
    return std::any_of(variants.begin(), variants.end(),
                       [&](const MethodVariant& each) { return each.name == variant && each.unbiased; });
}

const Curve* Study::curve(const std::string& scene, const std::string& variant, const std::string& channel,
                          const std::string& region) const {
    for (const Curve& each : curves)
        if (each.scene == scene && each.variant == variant && each.channel == channel && each.region == region)
            return &each;
    return nullptr;
}

bool Study::noise_subtracted(const std::string& scene, const std::string& channel, const std::string& region) const {
    return std::any_of(curves.begin(), curves.end(), [&](const Curve& curve) {
        return curve.scene == scene && curve.channel == channel && curve.region == region &&
               std::any_of(curve.points.begin(), curve.points.end(),
                           [](const BudgetPoint& point) { return point.excess > 0; });
    });
}

}  // namespace raylex::experiments
