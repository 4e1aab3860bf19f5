// Prints the plan of an experiment.
#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "experiments/program/console.h"
#include "experiments/study/run/cells/run_parts.h"
#include "experiments/study/run/run_progress.h"
#include "experiments/study/run/runner.h"
#include "experiments/study/run/workers/estimates.h"
#include "experiments/study/run/workers/run_worker.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

/// Requirements of all pairs of scene and settings, and the scenes that cannot be rendered.
struct Survey {
    std::set<std::pair<std::size_t, std::size_t>> seen;
    std::map<std::size_t, Error> broken;
    std::uint64_t largest = 0;  ///< bytes of a frame buffer
};

Survey survey(const Plan& plan, RunWorker& worker, const std::atomic<bool>* stop) {
    Survey result;
    for (const PlannedRun& each : plan.runs) {
        if (stop != nullptr && stop->load()) break;
        if (!result.seen.emplace(each.scene, each.variant).second || result.broken.contains(each.scene)) continue;
        auto bytes = worker.frame_buffer_bytes(each.scene, each.variant);
        if (bytes) result.largest = std::max(result.largest, *bytes);
        else result.broken.emplace(each.scene, bytes.error());
    }
    return result;
}

/// Prints all errors except the last one, which it returns.
Status broken_scenes(const ExperimentConfig& config, const std::map<std::size_t, Error>& broken) {
    for (const auto& [scene, error] : broken) {
        Error told = error;
        told.message = "scene '" + config.scenes[scene].name + "' fails, so all its cells fail: " + told.message;
        if (scene == broken.rbegin()->first) return told;
        static_cast<void>(report_error(told));
    }
    return success();
}

/// Returns ", references about 3 min 20 s, unless they exist already".
std::string references_text(const ExperimentConfig& config, const Estimates& estimates) {
    if (config.reference.method.empty()) return {};
    double references = 0;
    bool known = true;
    for (std::size_t i = 0; i < config.scenes.size(); ++i) {
        if (!config.scenes[i].reference_file.empty()) continue;
        const auto seconds = estimates.reference_seconds(i);
        references += seconds.value_or(0);
        known = known && seconds;
    }
    if (!(references > 0)) return {};
    return std::string(", references ") + (known ? "about " : "at least ") + duration_text(references) +
           ", unless they exist already";
}

}  // namespace

Status print_plan(const ExperimentConfig& config, const std::string& directory, const Shard& shard, bool calibrate,
                  const std::atomic<bool>* stop) {
    auto plan = make_plan(config);
    if (!plan) return plan.error();
    RunWorker worker(config, *plan, directory, stop, true);
    Estimates estimates(config);
    const auto [seen, broken, largest] = survey(*plan, worker, stop);
    if (stop != nullptr && stop->load()) return success();
    const transport::Stopwatch watch;
    std::vector<std::string> warnings;
    std::set<std::size_t> skips;
    for (const auto& [scene, error] : broken) skips.insert(scene);
    if (calibrate) warnings = estimates.calibrate(worker, *plan, skips, stop);
    if (stop != nullptr && stop->load()) return success();
    const double measured = watch.wall();
    double total = 0;
    std::size_t unknown = 0, count = 0;
    WorkList work = split_runs(
        config, *plan, [&](std::size_t scene, std::size_t variant) { return worker.reason_to_keep(scene, variant); },
        shard.split_runs);
    for (std::size_t i = 0; i < work.items.size(); ++i) {
        if (!shard.has(i)) continue;
        ++count;
        const PlannedRun& each = work.items[i];
        if (broken.contains(each.scene)) {
            print_line(each.run.id + "  FAILS: its scene cannot be rendered");
            continue;
        }
        const auto seconds = estimates.seconds(each);
        if (seconds) total += *seconds;
        else ++unknown;
        print_line(each.run.id + "  seed " + std::to_string(each.run.seed) + "  " +
                   (seconds ? "about " + duration_text(*seconds) : std::string("time unknown")));
    }
    for (const auto* notes : {&plan->notes, &work.notes})
        for (const std::string& note : *notes) print_line("note: " + note);
    for (const std::string& warning : warnings) print_line("warning: " + warning);
    print_line((shard.split_runs > 1 ? counted(count, "cell or part of one", "cells and parts of cells")
                                     : counted(count, "cell")) +
               (shard.parts > 1 ? " of " + std::to_string(work.items.size()) : "") + ": " +
               counted(config.scenes.size(), "scene") + ", " +
               counted(seen.size(), "pair of scene and settings", "pairs of scene and settings") + ", " +
               counted(config.budgets.size(), "budget") + ", " + counted(config.replicates, "replicate"));
    print_line("time: " + time_left_text(unknown == count ? -1 : total, unknown) +
               (unknown > 0 ? " (the time of " + counted(unknown, "cell") + " is unknown)" : "") +
               references_text(config, estimates) +
               (calibrate ? "; measured by a short render of every scene with all settings, " +
                                duration_text(measured) + " in total"
                          : "; the times for budgets of samples and errors are unknown without a calibration"));
    print_line("memory: " + display::memory_text(largest) + " for the largest frame buffer" +
               (config.checkpoint_seconds > 0 ? ", as much again for its checkpoints" : "") +
               "; in addition to the scenes");
    return broken_scenes(config, broken);
}

}  // namespace raylex::experiments
