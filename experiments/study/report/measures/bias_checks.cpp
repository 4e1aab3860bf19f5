#include "experiments/study/report/measures/bias_checks.h"

#include <algorithm>
#include <cmath>

namespace raylex::experiments {
namespace {

/// Methods with splats store no moments. The variance of a reference by such a method is that of the method's
/// replicates, scaled by the number of samples; empty if that is unknown.
std::vector<double> variance_by_samples(const BiasCandidate& same, double reference_samples) {
    if (same.side.replicates.size() < 2 || !(same.samples > 0) || !(reference_samples > 0)) return {};
    std::vector<double> variance(same.side.replicates.front().size());
    for (std::size_t block = 0; block < variance.size(); ++block)
        variance[block] = block_moments(same.side.replicates, block).variance * same.samples / reference_samples;
    return variance;
}

/// Replaces, in each block of the reference, the places that differ most from its method's own replicates by their
/// values: a pixel and those within reach of its splats. The variance of the replicates does not show rare samples that
/// only the reference has.
constexpr int rare_places = 3;  // of 25 pixels each; a block has 256 pixels, so most of it stays
PixelArray without_rarest(PixelArray reference, const std::vector<double>& mean) {
    if (reference.values.size() != mean.size()) return reference;
    const std::size_t n = reference.components, across = (reference.width + bias_block - 1) / bias_block;
    std::vector<std::pair<double, std::size_t>> rarest(block_count(reference.width, reference.height));
    for (std::size_t pixel = 0; pixel < reference.width * reference.height; ++pixel) {
        double difference = 0;
        for (std::size_t c = 0; c < n; ++c)
            difference += std::abs(reference.values[n * pixel + c] - mean[n * pixel + c]);
        const std::size_t x = pixel % reference.width, y = pixel / reference.width;
        auto& most = rarest[y / bias_block * across + x / bias_block];
        most = std::max(most, std::pair(difference, pixel));
    }
    constexpr std::size_t reach = 2;  // reach of a splat with any of the pixel filters
    for (const auto& [difference, pixel] : rarest) {
        const std::size_t x = pixel % reference.width, y = pixel / reference.width;
        for (std::size_t row = y - std::min(y, reach); row < std::min(y + reach + 1, reference.height); ++row)
            for (std::size_t column = x - std::min(x, reach); column < std::min(x + reach + 1, reference.width);
                 ++column)
                for (std::size_t c = 0; c < n; ++c) {
                    const std::size_t at = n * (row * reference.width + column) + c;
                    reference.values[at] = mean[at];
                }
    }
    return reference;
}

class BiasCheck {
  public:
    BiasCheck(Study& study, const SceneInfo& scene, const ChannelInfo& channel, const BiasCandidates& candidates)
        : study_(study), scene_(scene), channel_(channel), candidates_(candidates), first_(study.bias.size()) {
        options_.level = study.options.bias_level;
        options_.channels = static_cast<double>(scene.channels.size());
    }

    void run_checks(const PixelArray& reference, const std::optional<PixelArray>& variance) {
        BiasSide truth{{block_means(reference)}, {}};
        if (variance) truth.variance = block_variances(*variance);
        BiasSide even = truth;
        if (const auto same = candidates_.find(scene_.reference_method); !variance && same != candidates_.end()) {
            truth.variance = variance_by_samples(same->second, static_cast<double>(scene_.reference_samples));
            PixelArray common = reference;
            for (int place = 0; place < rare_places; ++place) common = without_rarest(common, same->second.mean);
            even = {{block_means(common)}, truth.variance};
        }
        for (const MethodVariant& variant : study_.variants)
            if (candidates_.contains(variant.name)) test(variant, truth, even);
        const std::vector<BiasEntry> by_reference(study_.bias.begin() + static_cast<std::ptrdiff_t>(first_),
                                                  study_.bias.end());
        test_own(by_reference);
        for (std::size_t i = first_; i < study_.bias.size(); ++i) {
            BiasEntry& entry = study_.bias[i];
            const bool uncertain =
                !variance || (heavy(scene_.reference_method) && entry.result.worst_difference.value > 0);
            if (!entry.result.differs || !entry.against.empty() || !entry.caveat.empty() || !uncertain) continue;
            if (std::none_of(by_reference.begin(), by_reference.end(),
                             [&](const BiasEntry& other) { return confirms(other, entry); }))
                entry.caveat = std::string("it differs from the reference, ") +
                               (variance ? "whose method meets rare samples" : "whose own error is unknown") +
                               ", and no other method's images confirm it";
        }
    }

  private:
    void test(const MethodVariant& variant, const BiasSide& truth, const BiasSide& even) {
        const BiasCandidate& candidate = candidates_.at(variant.name);
        const BiasTest result = test_bias(candidate.side, truth, options_);
        const bool rare = result.differs && !test_bias(candidate.side, even, options_).differs;
        study_.bias.push_back({scene_.name,
                               variant.name,
                               channel_.name,
                               candidate.budget,
                               candidate.side.replicates.size(),
                               result,
                               rare,
                               omitted_in(*study_.experiment, scene_.name, variant.name, channel_),
                               {},
                               {}});
    }

    /// Compares the method that made the reference with the images of another method.
    void test_own(const std::vector<BiasEntry>& by_reference) {
        const std::string& own = scene_.reference_method;
        const auto entry = std::find_if(study_.bias.begin() + static_cast<std::ptrdiff_t>(first_), study_.bias.end(),
                                        [&](const BiasEntry& each) { return each.variant == own; });
        if (entry == study_.bias.end()) return;
        const auto noise = [](const BiasCandidate& each) {
            const std::size_t whole = each.side.replicates.front().size() - 1;
            return block_moments(each.side.replicates, whole).variance /
                   static_cast<double>(each.side.replicates.size());
        };
        const BiasCandidate* run_checks = nullptr;
        bool others = false;
        for (const BiasEntry& other : by_reference) {
            if (other.variant == own || !can_test(other)) continue;
            others = true;
            const BiasCandidate& candidate = candidates_.at(other.variant);
            if (!agrees(other) || (run_checks != nullptr && noise(*run_checks) <= noise(candidate))) continue;
            run_checks = &candidate;
            entry->against = other.variant;
        }
        if (run_checks != nullptr) {
            entry->result = test_bias(candidates_.at(own).side, run_checks->side, options_);
            entry->heavy_tail = false;
        } else if (others) entry->caveat = "the method made the reference, and no other method agrees with it";
        else entry->result.note = "the method made the reference, so a mistake in both is not found";
    }

    [[nodiscard]] bool can_test(const BiasEntry& entry) const {
        return study_.unbiased(entry.variant) && entry.omitted.empty() && entry.result.tested;
    }

    static bool agrees(const BiasEntry& entry) { return !entry.result.differs && entry.result.blind.empty(); }

    /// Returns whether the images of `other` confirm the difference of `entry` from the reference, so that the
    /// reference alone is not responsible. The images of the reference's own method count too, because they share no
    /// sample with it.
    [[nodiscard]] bool confirms(const BiasEntry& other, const BiasEntry& entry) const {
        if (other.variant == entry.variant || !can_test(other) || heavy(other.variant)) return false;
        if (other.variant != scene_.reference_method && !agrees(other)) return false;
        const BiasTest result =
            test_bias(candidates_.at(entry.variant).side, candidates_.at(other.variant).side, options_);
        return result.differs && result.worst_difference.value * entry.result.worst_difference.value > 0;
    }

    /// Returns whether a few rare samples dominate the images of a variant.
    [[nodiscard]] bool heavy(const std::string& variant) const {
        const Curve* curve = study_.curve(scene_.name, variant, channel_.name);
        const auto candidate = candidates_.find(variant);
        return curve != nullptr && candidate != candidates_.end() &&
               std::any_of(curve->points.begin(), curve->points.end(), [&](const BudgetPoint& point) {
                   return point.budget == candidate->second.budget && point.group.heavy_tail;
               });
    }

    Study& study_;
    const SceneInfo& scene_;
    const ChannelInfo& channel_;
    const BiasCandidates& candidates_;
    const std::size_t first_;
    BiasOptions options_;
};

}  // namespace

void offer_candidate(BiasCandidate& best, double budget, const std::vector<const StudyRun*>& runs,
                     const std::vector<PixelArray>& images) {
    BiasCandidate offered;
    offered.budget = budget;
    double cost = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (images[i].values.empty()) continue;
        offered.side.replicates.push_back(block_means(images[i]));
        offered.mean.resize(images[i].values.size(), 0);
        for (std::size_t k = 0; k < offered.mean.size(); ++k) offered.mean[k] += images[i].values[k];
        cost +=
            runs[i]->samples_per_pixel > 0 ? static_cast<double>(runs[i]->samples_per_pixel) : runs[i]->wall_seconds;
    }
    if (offered.side.replicates.empty()) return;
    for (double& value : offered.mean) value /= static_cast<double>(offered.side.replicates.size());
    offered.weight = offered.side.replicates.size() < 2 ? 0 : cost;
    for (const StudyRun* run : runs)
        offered.samples += static_cast<double>(run->samples_per_pixel) / static_cast<double>(runs.size());
    if (offered.weight > best.weight) best = std::move(offered);
}

void check_bias(Study& study, const SceneInfo& scene, const ChannelInfo& channel, BiasCandidates candidates,
                const PixelArray& reference, const std::optional<PixelArray>& variance) {
    std::erase_if(candidates, [](const auto& each) { return each.second.side.replicates.empty(); });
    BiasCheck(study, scene, channel, candidates).run_checks(reference, variance);
}

}  // namespace raylex::experiments
