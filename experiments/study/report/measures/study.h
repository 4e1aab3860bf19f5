// An experiment measured and judged: what every table and plot of its report shows.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "display/output/metrics/image_metrics.h"
#include "experiments/study/analysis/bias.h"
#include "experiments/study/analysis/convergence.h"
#include "experiments/study/analysis/intervals.h"
#include "experiments/study/metrics.h"
#include "experiments/study/report/study_report.h"

namespace raylex::experiments {

/// A method with one choice of the swept settings.
struct MethodVariant {
    std::string name;  ///< "path max_depth=8"
    std::string method;
    NamedValues settings;      ///< that its method sweeps
    NamedValues all_settings;  ///< these and the method's own; what neither says is at its default
    bool unbiased = true;
};

/// Metrics of whole images that a study measures. hdr_flip is left to `raylex compare`: it costs a flip for each
/// exposure.
inline constexpr std::array<display::ImageMetric, 2> seen_metrics{display::ImageMetric::ssim,
                                                                  display::ImageMetric::flip};

/// One channel of one cell on one region.
struct CellErrors {
    const Cell* cell = nullptr;
    std::string variant, channel, region;  ///< region "": the whole image
    display::ErrorMeasures measures;
    double relmse_excess = 0, mse_excess = 0;  ///< what the reference's noise adds in expectation; 0 where not known
    /// By seen_metrics; NaN but for the beauty on the whole image, and where a value is not finite.
    std::array<double, seen_metrics.size()> seen{std::numeric_limits<double>::quiet_NaN(),
                                                 std::numeric_limits<double>::quiet_NaN()};
};

/// All replicates of one budget on a curve.
struct BudgetPoint {
    double budget = 0;
    BudgetGroup group;                                      ///< for fits: errors with the reference's noise subtracted
    Interval squared, relative;                             ///< relmse-mean, noise subtracted; and its root
    double excess = 0;                                      ///< of the reference in relmse-mean
    Interval efficiency;                                    ///< 1 / (relmse-mean x seconds)
    double seconds = 0;                                     ///< mean, by the study's clock: what it is compared by
    double wall_seconds = 0, cpu_seconds = 0, samples = 0;  ///< means
    double tail_index = 0;                                  ///< of TailMonitor
};

/// A variant's error on a channel and region of a scene over its budgets.
struct Curve {
    std::string scene, variant, channel, region;
    BudgetKind budget_kind = BudgetKind::samples;
    std::vector<BudgetPoint> points;  ///< by seconds
    SlopeVerdict slope;
    std::vector<TimeToError> times;
    std::optional<PredictionCheck> prediction;
    Interval speed_up;   ///< against the scene's first variant, each at its largest budget
    bool first = false;  ///< is that one
};

enum class BiasJudgement : std::uint8_t {
    not_tested,
    not_judged,   ///< the method declares that it does not find some of the channel's paths
    rare,         ///< the images differ, but a few rare samples decide
    differs,      ///< from what it is compared with, beyond noise
    cannot_tell,  ///< no difference, or one that says too little
    none_found
};

struct BiasEntry {
    std::string scene, variant, channel;
    double budget = 0;
    std::size_t replicates = 0;
    BiasVerdict verdict;
    /// A few rare samples decide, of the cells or of a reference whose own variance is not known: what the test assumes
    /// does not hold, and no method is found biased by it.
    bool heavy_tail = false;
    std::string omitted;  ///< paths of this channel that the method says it does not find: then it is not judged by it
    std::string against;  ///< the method whose replicates it is compared with; empty: the scene's reference
    std::string doubt;    ///< why neither agreement with the reference nor a difference from it says anything
    /// Why it cannot be told, where that is not for noise alone.
    [[nodiscard]] const std::string& reason() const { return doubt.empty() ? verdict.blind : doubt; }
    [[nodiscard]] BiasJudgement judgement() const;
    [[nodiscard]] bool convicts() const { return judgement() == BiasJudgement::differs; }
};

struct WordsEntry {
    std::string scene, variant;
    FirstWords first;
};

/// Two variants that differ in one setting, of one method or of two.
struct SettingEffect {
    /// Of one method: the setting, its values, and the method with what it sweeps beside. Of two methods: "method",
    /// their names, and the setting in which they differ.
    std::string scene{}, channel{}, key{}, from{}, to{}, others{};
    Interval speed_up{};    ///< of `to` against `from`
    double by_medians = 0;  ///< the same ratio of the medians over replicates of relmse-mean x seconds; NaN: not known
    std::string variant{}, against{};  ///< the two by name
};

/// The expression of paths that a variant says it does not find in a scene and that a channel has, too; empty: none.
std::string omitted_in(const Experiment& experiment, const std::string& scene, const std::string& variant,
                       const ChannelInfo& channel);

/// The error of a curve's most expensive budget by spatial frequency, over its replicates (analysis/spectrum.h). Powers
/// are relative to the square of m = mean(|b|): the root of their mean over all frequencies is rmse / m.
struct ErrorSpectrum {
    struct Point {
        double frequency = 0;                  ///< cycles per pixel; first 0, the error of the image's mean
        double mean = 0, least = 0, most = 0;  ///< over replicates
    };
    const Curve* curve = nullptr;
    std::size_t replicates = 0;
    double reference_error = 0;  ///< root of the power of the reference's noise at any frequency; 0 where not known
    std::vector<Point> points;
    PixelArray deviation;  ///< of the beauty's pixels over several replicates, relative to m; else empty
};

struct Omission {
    std::string what, reason;
};

/// What a variant has reached of a scene's channel in a time.
struct Standing {
    const Curve* curve = nullptr;
    Interval squared;           ///< relmse-mean
    bool extrapolated = false;  ///< no budgets on both sides of that time: error times time goes on as it is
};

/// A scene's channel, variant by variant, at the largest time that all of them reached.
struct MethodComparison {
    std::string scene, channel;
    double seconds = 0;
    std::vector<Standing> standings;                 ///< as Study::variants; no curve: not measured
    std::size_t best = 0, second = 0, measured = 0;  ///< of squared errors; valid with that many measured
    Interval ratio;                                  ///< of the second's to the best's
};

struct Study {
    const Experiment* experiment = nullptr;
    StudyReportOptions options;
    std::vector<MethodVariant> variants;
    std::vector<CellErrors> cells;
    std::vector<Curve> curves;  ///< scenes, then channels, regions and variants in the order of the config
    std::vector<BiasEntry> bias;
    std::vector<WordsEntry> words;
    std::vector<SettingEffect> effects;
    std::vector<MethodComparison> comparisons;
    std::vector<Omission> omissions;
    std::vector<ErrorSpectrum> spectra;  ///< of the curves of whole images, in their order

    /// Whether the config claims it of a variant.
    [[nodiscard]] bool unbiased(const std::string& variant) const;
    [[nodiscard]] const Curve* curve(const std::string& scene, const std::string& variant, const std::string& channel,
                                     const std::string& region = {}) const;
    /// Whether errors are less the reference's noise, which is not known of every reference.
    [[nodiscard]] bool noise_subtracted(const std::string& scene, const std::string& channel,
                                        const std::string& region = {}) const;
};

inline constexpr std::array<double, 5> target_errors{0.1, 0.05, 0.02, 0.01, 0.005};

std::string variant_name(const Cell& cell);

/// Reads every image once. What cannot be read or has no reference becomes an omission; errors are of regions that do
/// not fit their scene.
Result<Study> study_of(const Experiment& experiment, const StudyReportOptions& options);

/// The second half: curves and verdicts from what was measured.
void judge_curves(Study& study);
/// The first table of the page, for every channel on the whole image.
void compare_variants(Study& study);
/// Sign, size, interval and place of a difference: "-54 % [-56, -52] of the mean".
std::string finding_of(const Study& study, const BiasEntry& entry);
/// "whole image", "block at (16, 32)": of its most significant difference.
std::string block_text(const Study& study, const BiasEntry& entry);
/// A verdict with its reason: "cannot tell: a bias below 158 % of the mean would be missed".
std::string verdict_of(const Study& study, const BiasEntry& entry);
/// The shortest wrong path of the channel by which verdict_lines() name a difference: the first that differs. Of the
/// beauty, which all paths are in, that of any channel. Null: none is known.
const FirstWords::Word* first_word(const Study& study, const std::string& scene, const std::string& variant);
/// Which method a channel is best rendered by, in a sentence.
std::string best_sentence(const Study& study, const MethodComparison& comparison);
/// Sets CellErrors::seen, on all cores.
void measure_as_seen(Study& study);
/// Sets Study::spectra, on all cores; after judge_curves().
void measure_spectra(Study& study);
/// work(0) to work(count - 1), each once, in any order, by as many threads as there are cores.
void on_all_cores(std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace raylex::experiments
