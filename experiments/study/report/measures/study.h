// The measurements and verdicts of an experiment, for all tables and plots of its report.
#pragma once

#include <array>
#include <cstdint>
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
    NamedValues settings;      ///< settings swept by its method
    NamedValues all_settings;  ///< swept settings and the method's own; others have default values
    bool unbiased = true;
};

/// Perceptual metrics of a study. hdr_flip is left to `raylex compare`, because it computes one FLIP per exposure.
inline constexpr std::array<display::ImageMetric, 2> seen_metrics{display::ImageMetric::ssim,
                                                                  display::ImageMetric::flip};

/// The errors of one channel of one cell on one region.
struct RunErrors {
    const StudyRun* run = nullptr;
    std::string variant, channel, region;  ///< region "": the whole image
    display::ErrorMeasures measures;
    double relmse_excess = 0, mse_excess = 0;  ///< expected contribution of the reference's noise; 0 if unknown
    /// Values of seen_metrics; NaN except for the beauty on the whole image, and for non-finite values.
    std::array<double, seen_metrics.size()> seen{std::numeric_limits<double>::quiet_NaN(),
                                                 std::numeric_limits<double>::quiet_NaN()};
};

/// All replicates of one budget on a curve.
struct BudgetPoint {
    double budget = 0;
    BudgetGroup group;                                      ///< for fits: errors with the reference's noise subtracted
    Interval squared, relative;                             ///< relmse-mean with noise subtracted, and its root
    double excess = 0;                                      ///< the reference's contribution to relmse-mean
    Interval efficiency;                                    ///< 1 / (relmse-mean x seconds)
    double seconds = 0;                                     ///< mean by the study's clock, for comparisons
    double wall_seconds = 0, cpu_seconds = 0, samples = 0;  ///< means
    double tail_index = 0;                                  ///< TailMonitor::index
};

/// The error of a variant over its budgets, for a channel and region of a scene.
struct Curve {
    std::string scene, variant, channel, region;
    BudgetKind budget_kind = BudgetKind::samples;
    std::vector<BudgetPoint> points;  ///< by seconds
    SlopeTest slope;
    std::vector<TimeToError> times;
    std::optional<PredictionCheck> prediction;
    Interval speed_up;   ///< relative to the scene's first variant, each at its largest budget
    bool first = false;  ///< this is the first variant
};

enum class BiasConclusion : std::uint8_t {
    not_tested,
    omits_paths,  ///< the method declares that it does not find some paths of the channel
    rare,         ///< the images differ, but a few rare samples dominate
    differs,      ///< differs from the comparison by more than noise
    cannot_tell,  ///< no difference, or an inconclusive one
    none_found
};

struct BiasEntry {
    std::string scene, variant, channel;
    double budget = 0;
    std::size_t replicates = 0;
    BiasTest result;
    /// True if a few rare samples dominate the cells, or a reference of unknown variance. The test's assumptions then
    /// do not hold, so no method is reported as biased.
    bool heavy_tail = false;
    /// paths of this channel that the method declares not to find; it is then not judged by the channel
    std::string omitted;
    std::string against;  ///< the method whose replicates it is compared with; empty: the scene's reference
    std::string caveat;   ///< why agreement with the reference, or difference from it, is not evidence
    /// The reason why the result is inconclusive; empty if the reason is noise.
    [[nodiscard]] const std::string& reason() const { return caveat.empty() ? result.blind : caveat; }
    [[nodiscard]] BiasConclusion conclusion() const;
    [[nodiscard]] bool convicts() const { return conclusion() == BiasConclusion::differs; }
};

struct CounterexampleEntry {
    std::string scene, variant;
    Counterexamples first;
};

/// Two variants that differ in one setting, of one method or of two.
struct SettingEffect {
    /// Within one method: the setting, its values, and the method with its other swept settings. Between methods:
    /// "method", the two names, and the setting in which they differ.
    std::string scene{}, channel{}, key{}, from{}, to{}, others{};
    Interval speed_up{};               ///< of `to` relative to `from`
    double by_medians = 0;             ///< ratio of the medians over replicates of relmse-mean x seconds; NaN: unknown
    std::string variant{}, against{};  ///< names of the two variants
};

/// Returns the expression of paths that a variant declares not to find in a scene and that are in a channel; empty if
/// none.
std::string omitted_in(const Experiment& experiment, const std::string& scene, const std::string& variant,
                       const ChannelInfo& channel);

/// The error spectrum of a curve's largest budget, over its replicates (analysis/spectrum.h). Powers are relative to
/// the square of m = mean(|b|), so the root of their mean over all frequencies is rmse / m.
struct ErrorSpectrum {
    struct Point {
        double frequency = 0;                  ///< cycles per pixel; the first is 0, the error of the image's mean
        double mean = 0, least = 0, most = 0;  ///< over replicates
    };
    const Curve* curve = nullptr;
    std::size_t replicates = 0;
    double reference_error = 0;  ///< root of the reference's noise power, equal at all frequencies; 0 if unknown
    std::vector<Point> points;
    PixelArray deviation;  ///< of the beauty's pixels over several replicates, relative to m; otherwise empty
};

struct Omission {
    std::string what, reason;
};

/// The error of a variant for a scene's channel at a given time.
struct Standing {
    const Curve* curve = nullptr;
    Interval squared;           ///< relmse-mean
    bool extrapolated = false;  ///< no budgets on both sides of that time: extrapolated with constant error x time
};

/// The variants of a scene's channel at the largest time that all of them reached.
struct MethodComparison {
    std::string scene, channel;
    double seconds = 0;
    std::vector<Standing> standings;                 ///< in the order of Study::variants; without a curve: not measured
    std::size_t best = 0, second = 0, measured = 0;  ///< by squared error; valid if at least that many are measured
    Interval ratio;                                  ///< of the second's squared error to the best's
};

struct Study {
    const Experiment* experiment = nullptr;
    StudyReportOptions options;
    std::vector<MethodVariant> variants;
    std::vector<RunErrors> runs;
    std::vector<Curve> curves;  ///< by scene, channel, region and variant, in the order of the config
    std::vector<BiasEntry> bias;
    std::vector<CounterexampleEntry> words;
    std::vector<SettingEffect> effects;
    std::vector<MethodComparison> comparisons;
    std::vector<Omission> omissions;
    std::vector<ErrorSpectrum> spectra;  ///< of the curves of whole images, in their order

    /// Returns whether the config declares the variant unbiased.
    [[nodiscard]] bool unbiased(const std::string& variant) const;
    [[nodiscard]] const Curve* curve(const std::string& scene, const std::string& variant, const std::string& channel,
                                     const std::string& region = {}) const;
    /// Returns whether errors exclude the reference's noise, which is not known for every reference.
    [[nodiscard]] bool noise_subtracted(const std::string& scene, const std::string& channel,
                                        const std::string& region = {}) const;
};

inline constexpr std::array<double, 5> target_errors{0.1, 0.05, 0.02, 0.01, 0.005};

std::string variant_name(const StudyRun& run);

/// Reads every image once. Unreadable images and missing references become omissions. Errors: a region does not fit its
/// scene.
Result<Study> study_of(const Experiment& experiment, const StudyReportOptions& options);

/// Computes curves and verdicts from the measurements, the second half of study_of().
void check_curves(Study& study);
/// Makes the first table of the page, for every channel on the whole image.
void compare_variants(Study& study);
/// Returns sign, size, interval and place of a difference: "-54 % [-56, -52] of the mean".
std::string finding_of(const Study& study, const BiasEntry& entry);
/// Returns the place of the most significant difference: "whole image", "block at (16, 32)".
std::string block_text(const Study& study, const BiasEntry& entry);
/// Returns a verdict with its reason: "cannot tell: a bias below 158 % of the mean would be missed".
std::string result_of(const Study& study, const BiasEntry& entry);
/// Returns the shortest wrong path of the channel that result_lines() names: the first channel that differs. For the
/// beauty, which contains all paths, that of any channel. Null if unknown.
const Counterexamples::Counterexample* first_counterexample(const Study& study, const std::string& scene,
                                                            const std::string& variant);
/// Returns a sentence about the best method for a channel.
std::string best_sentence(const Study& study, const MethodComparison& comparison);
/// Sets RunErrors::seen, using all cores.
void measure_as_seen(Study& study);
/// Sets Study::spectra, using all cores. Call it after check_curves().
void measure_spectra(Study& study);

}  // namespace raylex::experiments
