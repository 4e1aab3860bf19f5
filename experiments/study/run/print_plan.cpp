// What an experiment will be, told before it is.
#include <algorithm>
#include <set>

#include "display/buffer/memory_estimate.h"
#include "experiments/cli/console.h"
#include "experiments/study/run/cell_parts.h"
#include "experiments/study/run/estimates.h"
#include "experiments/study/run/run_progress.h"
#include "experiments/study/run/runner.h"
#include "transport/render/clock.h"

namespace raylex::experiments {

Status print_plan(const ExperimentConfig& config, const std::string& directory, const Shard& shard, bool calibrate,
                  const std::atomic<bool>* stop) {
    auto plan = make_plan(config);
    if (!plan) return plan.error();
    SceneStore scenes(config);
    Estimates estimates(config);
    std::uint64_t largest = 0;
    std::set<std::pair<std::size_t, std::size_t>> seen;
    for (const PlannedCell& each : plan->cells) {
        if (!seen.emplace(each.scene, each.variant).second) continue;
        auto bytes = scenes.frame_buffer_bytes(each.scene, each.variant);
        if (!bytes) return bytes.error();
        largest = std::max(largest, *bytes);
    }
    const transport::Stopwatch watch;
    if (calibrate && !estimates.calibrate({config, *plan, scenes, directory, {}, stop})) return success();
    const double measured = watch.wall();
    double total = 0;
    std::size_t unknown = 0, count = 0;
    auto work = split_cells(config, *plan, scenes, shard.split_cells);
    if (!work) return work.error();
    for (std::size_t i = 0; i < work->items.size(); ++i) {
        if (!shard.has(i)) continue;
        ++count;
        const PlannedCell& each = work->items[i];
        const auto seconds = estimates.seconds(each);
        if (seconds) total += *seconds;
        else ++unknown;
        print_line(each.cell.id + "  seed " + std::to_string(each.cell.seed) + "  " +
                   (seconds ? "about " + duration_text(*seconds) : std::string("time not known before it is run")));
    }
    double references = 0;
    bool references_known = true;
    if (!config.reference.method.empty())
        for (std::size_t i = 0; i < config.scenes.size(); ++i) {
            if (!config.scenes[i].reference_file.empty()) continue;
            const auto seconds = estimates.reference_seconds(i);
            references += seconds.value_or(0);
            references_known = references_known && seconds;
        }
    for (const auto* notes : {&plan->notes, &work->notes})
        for (const std::string& note : *notes) print_line("note: " + note);
    print_line(std::to_string(count) + (shard.split_cells > 1 ? " cells and parts of cells" : " cells") +
               (shard.parts > 1 ? " of " + std::to_string(work->items.size()) : "") +
               ": " + std::to_string(config.scenes.size()) + " scenes, " + std::to_string(seen.size()) +
               " pairs of scene and settings, " + std::to_string(config.budgets.size()) + " budgets, " +
               std::to_string(config.replicates) + " replicates");
    print_line("time: " + time_left_text(unknown == count ? -1 : total, unknown) +
               (unknown > 0 ? " (" + std::to_string(unknown) + " cells cannot be told)" : "") +
               (references > 0 ? std::string(", references ") + (references_known ? "about " : "at least ") +
                                     duration_text(references) + ", unless they are kept from before"
                               : "") +
               (calibrate
                    ? "; from a short render of every scene by every setting, " + duration_text(measured) + " in all"
                    : "; budgets of samples and errors are not known without a calibration"));
    print_line("memory: " + display::memory_text(largest) + " for the largest frame buffer" +
               (config.checkpoint_seconds > 0 ? ", as much again for its checkpoints" : "") + "; beside the scenes");
    return success();
}

}  // namespace raylex::experiments
