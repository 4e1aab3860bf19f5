#include "experiments/study/run/workers/estimates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

/// Wall seconds, including preparation. If the first one is too short to render anything, as on a busy machine, the
/// others follow.
constexpr std::array calibration_seconds{0.2, 2.0, 20.0};
constexpr std::uint64_t calibration_samples = 64;

}  // namespace

Result<Calibration> calibration_of(const ExperimentConfig& config, SceneStore& scenes, std::size_t scene,
                                   std::size_t variant, const std::atomic<bool>* stop) {
    RenderOrder order{.scene = scene, .variant = variant, .samples = calibration_samples};
    order.seed = seed_for(config.seed, "calibration", config.scenes[scene].name);
    for (const double seconds : calibration_seconds) {
        order.limit = transport::SampleLimit{.seconds = seconds};
        auto rendered = scenes.render(order, {}, stop);
        if (!rendered) return rendered.error();
        if (stop != nullptr && stop->load()) return error_at({}, "interrupted");
        const transport::RenderOutput& output = rendered->output;
        const bool whole = output.samples.complete && output.samples.per_pixel >= 2;
        // A pass that the time limit ended is as good for the speed as a whole one.
        const double samples =
            static_cast<double>(output.statistics.camera_samples) / output.view.width / output.view.height;
        if (!(samples > 0)) continue;
        const double setup = std::max(0.0, rendered->seconds - output.statistics.render_seconds);
        return Calibration{setup,
                           output.statistics.render_seconds,
                           output.samples.complete ? static_cast<double>(output.samples.per_pixel) : samples,
                           whole ? relative_error(output) : -1,
                           rendered->warnings,
                           rendered->peak_memory_bytes};
    }
    return error_at({}, "no sample was finished in " + duration_text(calibration_seconds.back()));
}

std::vector<std::string> Estimates::calibrate(RunWorker& worker, const Plan& plan, const std::set<std::size_t>& skips,
                                              const std::atomic<bool>* stop) {
    std::set<std::pair<std::size_t, std::size_t>> wanted;
    for (const PlannedRun& each : plan.runs) wanted.emplace(each.scene, each.variant);
    if (!config_.reference.method.empty())
        for (std::size_t scene = 0; scene < config_.scenes.size(); ++scene)
            wanted.emplace(scene, config_.reference.variant);
    std::vector<std::string> warnings;
    for (const auto& [scene, variant] : wanted) {
        if (stop != nullptr && stop->load()) break;
        if (skips.contains(scene) || !config_.methods[config_.variants[variant].method].command.empty()) continue;
        auto measured = worker.calibrate(scene, variant);
        if (!measured) {
            std::string who = config_.methods[config_.variants[variant].method].name;
            for (const auto& [key, value] : config_.variants[variant].settings) who += " " + key + "=" + value;
            warnings.push_back("the time of " + who + " on " + config_.scenes[scene].name +
                               " is unknown: " + measured.error().to_string());
            continue;
        }
        peak_memory_bytes_ = std::max(peak_memory_bytes_, measured->peak_memory_bytes);
        const double error = measured->relative_error;
        rates_[{scene, variant}] = {measured->setup_seconds, measured->seconds, measured->samples,
                                    error < 0 ? -1 : error * std::sqrt(measured->samples)};
        for (std::string& each : measured->warnings)
            if (std::find(warnings.begin(), warnings.end(), each) == warnings.end())
                warnings.push_back(std::move(each));
    }
    return warnings;
}

void Estimates::learn(const PlannedRun& planned, const StudyRun& done, double relative_error) {
    if (done.failed || done.samples_per_pixel == 0) return;
    Rate& rate = rates_[{planned.scene, planned.variant}];
    // New cells count as much as all earlier ones together, because machines change.
    rate.setup = 0;
    for (const Phase& phase : done.phases)
        if (phase.name == "prepare") rate.setup = phase.wall_seconds;
    rate.seconds = rate.seconds / 2 + done.wall_seconds - rate.setup;
    rate.samples = rate.samples / 2 + static_cast<double>(done.samples_per_pixel);
    if (relative_error >= 0) rate.error_root = relative_error * std::sqrt(static_cast<double>(done.samples_per_pixel));
}

double Estimates::seconds_per_sample(const PlannedRun& planned) const {
    const auto found = rates_.find({planned.scene, planned.variant});
    return found == rates_.end() || found->second.samples <= 0 ? 0 : found->second.seconds / found->second.samples;
}

std::optional<double> Estimates::seconds_of(std::size_t scene, std::size_t variant, double samples,
                                            double error) const {
    const auto found = rates_.find({scene, variant});
    if (found == rates_.end() || found->second.samples <= 0) return std::nullopt;
    const Rate& rate = found->second;
    if (error > 0) {
        if (rate.error_root < 0) return std::nullopt;
        const double needed = std::max(64.0, std::pow(rate.error_root / error, 2));
        samples = samples > 0 ? std::min(samples, needed) : needed;
    }
    return rate.setup + samples * rate.seconds / rate.samples;
}

std::optional<double> Estimates::seconds(const PlannedRun& planned) const {
    const StudyRun& run = planned.run;
    if (run.budget_kind == BudgetKind::seconds) return run.budget;
    if (run.budget_kind == BudgetKind::error) return seconds_of(planned.scene, planned.variant, 0, run.budget);
    const bool is_part = !run.part_of.empty();
    const double samples = is_part ? static_cast<double>(run.end_sample - run.first_sample) : run.budget;
    return seconds_of(planned.scene, planned.variant, samples, 0);
}

std::optional<double> Estimates::reference_seconds(std::size_t scene) const {
    const ReferenceRequest& reference = config_.reference;
    return seconds_of(scene, reference.variant, static_cast<double>(reference.samples), reference.error);
}

}  // namespace raylex::experiments
