// One cell once more, and whether its bits are the same.
#include <algorithm>
#include <utility>

#include "display/services/parameters.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/cell_files.h"
#include "experiments/study/run/cell_runner.h"
#include "experiments/study/run/results_state.h"
#include "experiments/study/run/runner.h"

namespace raylex::experiments {

Result<ReplayOutcome> replay_cell(ExperimentConfig config, const std::string& directory, const std::string& id,
                                  const std::atomic<bool>* stop) {
    auto results = read_experiment(directory);
    if (!results) return results.error();
    if (Status same = check_same_config(*results, config); !same) return same.error();
    std::vector<std::string> ids;
    for (const Cell& each : results->cells) ids.push_back(each.id);
    const auto cell =
        std::find_if(results->cells.begin(), results->cells.end(), [&](const Cell& each) { return each.id == id; });
    if (cell == results->cells.end()) {
        const std::string near = nearest_name(id, ids);
        return directory_error(directory, "there is no finished cell '" + id + "'; cells/ has them",
                               near.empty() ? "" : "did you mean '" + near + "'?");
    }
    auto plan = make_plan(config);
    if (!plan) return plan.error();
    const auto planned = std::find_if(plan->cells.begin(), plan->cells.end(),
                                      [&](const PlannedCell& each) { return each.cell.id == id; });
    if (cell->failed)
        return directory_error(failed_file(directory, id), "this cell failed, so there is nothing to compare with");
    if (planned == plan->cells.end()) return directory_error(directory, "the config plans no cell '" + id + "'");
    if (!config.methods[config.variants[planned->variant].method].command.empty())
        return directory_error(cell->directory,
                               "this cell is of an external renderer, whose bits raylex cannot promise");
    auto record = read_record(cell->directory);
    if (!record) return record.error();
    config.base.settings.isa = cell->isa;
    SceneStore scenes(config);
    auto again = render_again({config, *plan, scenes, directory, {}, stop}, *planned, *cell);
    if (!again) return again.error();
    ReplayOutcome outcome;
    outcome.difference = record->difference_from(again->output.frame_buffer);
    if (!outcome.difference.empty()) return outcome;
    std::string before, now;
    record->append_record(before);
    again->output.frame_buffer.append_record(now);
    outcome.same = before == now;
    if (outcome.same) return outcome;
    outcome.difference = "the sums of its pixels";
    for (const SceneInfo& each : results->scenes)
        if (auto scene = scenes.scene(planned->scene); each.name == cell->scene && scene && (*scene)->hash != each.hash)
            outcome.difference += "; the scene's files have changed since";
    return outcome;
}

}  // namespace raylex::experiments
