// Renders one cell again and compares its bits.
#include <stdlib.h>
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "display/output/reader/exr_reader.h"
#include "display/services/parameters.h"
#include "experiments/study/file_records.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/cells/run_files.h"
#include "experiments/study/run/cells/run_renderer.h"
#include "experiments/study/run/results_state.h"
#include "experiments/study/run/runner.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// A folder that is removed with its contents.
struct TemporaryFolder {
    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "raylex-replay-XXXXXX").string();
        if (mkdtemp(name.data()) != nullptr) path = name;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        if (!path.empty()) fs::remove_all(path, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::string path;
};

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Compares the pixels of two images. Headers differ because they contain times and machines.
Result<bool> same_pixels(const std::string& a, const std::string& b) {
    auto first = display::read_exr(a), second = display::read_exr(b);
    if (!first) return first.error();
    if (!second) return second.error();
    if (first->width != second->width || first->height != second->height ||
        first->layers.size() != second->layers.size())
        return false;
    for (std::size_t i = 0; i < first->layers.size(); ++i) {
        const display::ImageLayer &one = first->layers[i], &other = second->layers[i];
        if (one.name != other.name || one.planes.size() != other.planes.size()) return false;
        for (std::size_t c = 0; c < one.planes.size(); ++c) {
            const std::vector<float>&before = one.planes[c].values, &now = other.planes[c].values;
            if (before.size() != now.size() ||
                std::memcmp(before.data(), now.data(), before.size() * sizeof(float)) != 0)
                return false;
        }
    }
    return true;
}

/// Compares the arrays and the image of the new render with those of the cell.
Status compare_files(const StudyRun& run, const Rendered& again, const JobScene& scene, ReplayOutcome& outcome) {
    const TemporaryFolder folder;
    if (folder.path.empty()) return error_at({}, "cannot make a temporary folder; expected room in $TMPDIR");
    auto written = write_render_files(folder.path, again, scene, {});
    if (!written) return written.error();
    std::vector<std::string> names;
    for (const fs::directory_entry& each : fs::directory_iterator(folder.path))
        names.push_back(each.path().filename().string());
    std::sort(names.begin(), names.end());
    for (const std::string& name : names) {
        const std::string before = run.directory + "/" + name, now = folder.path + "/" + name;
        bool same = true;
        if (name == "record.bin") continue;  // its sums are equal; it also contains its origin
        if (!fs::exists(before)) {
            outcome.difference = name + ": this file is missing";
            return success();
        }
        if (name.ends_with(".exr")) {
            auto pixels = same_pixels(before, now);
            if (!pixels) return pixels.error();
            same = *pixels;
        } else {
            same = content_of(before) == content_of(now);
        }
        if (!same) {
            outcome.difference = name;
            return success();
        }
        outcome.compared.push_back(name);
    }
    return success();
}

}  // namespace

Result<ReplayOutcome> replay_run(ExperimentConfig config, const std::string& directory, const std::string& id,
                                 const std::atomic<bool>* stop) {
    auto results = read_experiment(directory);
    if (!results) return results.error();
    if (Status same = check_same_config(*results, config); !same) return same.error();
    std::vector<std::string> ids;
    for (const StudyRun& each : results->runs) ids.push_back(each.id);
    const auto run =
        std::find_if(results->runs.begin(), results->runs.end(), [&](const StudyRun& each) { return each.id == id; });
    if (run == results->runs.end()) {
        return directory_error(directory, "unknown cell '" + id + "'; cells/ has the finished cells",
                               near_miss(id, ids));
    }
    auto plan = make_plan(config);
    if (!plan) return plan.error();
    const auto planned =
        std::find_if(plan->runs.begin(), plan->runs.end(), [&](const PlannedRun& each) { return each.run.id == id; });
    if (run->failed)
        return directory_error(failed_file(directory, id), "this cell failed, so there is nothing to compare with");
    if (planned == plan->runs.end()) return directory_error(directory, "the config plans no cell '" + id + "'");
    if (!config.methods[config.variants[planned->variant].method].command.empty())
        return directory_error(run->directory, "this cell comes from an external renderer, whose bits may differ");
    ReplayOutcome outcome;
    outcome.difference = damage_of(*run);
    if (!outcome.difference.empty()) return outcome;
    if (!run->passes.empty() && run->budget_kind != BudgetKind::samples)
        return directory_error(run->directory, "each pass of this cell reached its own number of samples in its time");
    config.base.settings.machine.isa = run->isa;
    SceneStore scenes(config);
    auto again = render_again({config, *plan, scenes, directory, {}, stop}, *planned, *run);
    if (!again) return again.error();
    if (!again->output.samples.complete) return outcome;
    if (run->passes.empty()) {  // a sum of passes has no record
        auto record = read_record(run->directory);
        if (!record) return record.error();
        outcome.difference = record->difference_from(again->output.frame_buffer);
        if (!outcome.difference.empty()) return outcome;
        std::string before, now;
        record->append_record(before);
        again->output.frame_buffer.append_record(now);
        if (before != now) {
            outcome.difference = "record.bin: the sums of its pixels";
            for (const SceneInfo& each : results->scenes)
                if (auto scene = scenes.scene(planned->scene);
                    each.name == run->scene && scene && (*scene)->hash != each.hash)
                    outcome.difference += "; the scene's files have changed since";
            return outcome;
        }
        outcome.compared = {"record.bin"};
    }
    auto scene = scenes.scene(planned->scene, config.variants[planned->variant].effects);
    if (!scene) return scene.error();
    if (Status s = compare_files(*run, *again, *(*scene)->loaded, outcome); !s) return s.error();
    outcome.same = outcome.difference.empty();
    return outcome;
}

}  // namespace raylex::experiments
