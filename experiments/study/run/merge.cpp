#include "experiments/study/run/merge.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "display/services/parameters.h"
#include "experiments/study/results_file.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

Error merge_error(const std::string& directory, std::string message, std::string hint = {}) {
    return error_at({directory, 0, 0}, std::move(message), std::move(hint));
}

Status check_one_experiment(const Experiment& first, const Experiment& other) {
    if (first.config_hash != other.config_hash)
        return merge_error(other.directory,
                           "these are results of another config (hash " + other.config_hash + ") than those in '" +
                               first.directory + "' (hash " + first.config_hash + ")",
                           "merge takes the shards of one config, with the same --set");
    for (const SceneInfo& scene : first.scenes)
        for (const SceneInfo& same : other.scenes)
            if (scene.name == same.name &&
                (scene.hash != same.hash || scene.width != same.width || scene.height != same.height))
                return merge_error(other.directory,
                                   "scene '" + scene.name + "' is another one than in '" + first.directory + "'");
    return success();
}

/// The directories in an order that does not depend on how they were given: of their first cells.
std::string order_key(const Experiment& experiment) {
    std::string key;
    for (const Cell& each : experiment.cells) key += each.id + (each.failed ? "!" : "") + "\n";
    return key;
}

Status copy(const std::string& from, const std::string& to) {
    std::error_code failed;
    fs::create_directories(fs::path(to).parent_path(), failed);
    fs::copy(from, to, fs::copy_options::recursive, failed);
    return failed ? merge_error(to, "cannot copy '" + from + "' here: " + failed.message()) : success();
}

/// The references that the experiments found, each once.
Status merge_references(const std::vector<Experiment>& experiments, Experiment& merged) {
    for (SceneInfo& scene : merged.scenes) {
        for (const Experiment& each : experiments)
            for (const SceneInfo& same : each.scenes) {
                if (same.name != scene.name || same.reference.empty()) continue;
                if (scene.reference.empty()) scene = same;
                else if (fs::path(scene.reference).filename() != fs::path(same.reference).filename())
                    return merge_error(each.directory, "the reference of scene '" + scene.name + "' is another one (" +
                                                           same.reference + ") than elsewhere (" + scene.reference +
                                                           ")");
            }
        if (scene.reference.empty()) continue;
        // One that stands in a shared cache stays there.
        for (const Experiment& each : experiments) {
            const fs::path inside = fs::path(each.directory) / "references" / fs::path(scene.reference).filename();
            std::error_code failed;
            if (!fs::exists(inside, failed) || !fs::equivalent(inside, scene.reference, failed)) continue;
            const std::string target = merged.directory + "/references/" + inside.filename().string();
            if (!fs::exists(target, failed))
                if (Status s = copy(inside.string(), target); !s) return s;
            scene.reference = target;
            break;
        }
    }
    return success();
}

}  // namespace

Result<MergeOutcome> merge_experiments(const std::vector<std::string>& directories, const std::string& output) {
    std::error_code failed;
    if (fs::exists(output, failed) && (!fs::is_directory(output, failed) || !fs::is_empty(output, failed)))
        return merge_error(output, "this is there already; expected a new directory for -o");
    std::vector<Experiment> experiments;
    for (const std::string& each : directories) {
        auto read = read_experiment(each);
        if (!read) return read.error();
        experiments.push_back(std::move(*read));
        if (Status s = check_one_experiment(experiments.front(), experiments.back()); !s) return s.error();
    }
    std::stable_sort(experiments.begin(), experiments.end(),
                     [](const Experiment& a, const Experiment& b) { return order_key(a) < order_key(b); });
    std::map<std::string, const Cell*> cells;
    std::map<std::string, std::string> from;  // cell -> directory of results
    for (const Experiment& each : experiments)
        for (const Cell& cell : each.cells) {
            const auto [known, is_new] = cells.emplace(cell.id, &cell);
            if (is_new || known->second->failed) {
                known->second = &cell;
                from[cell.id] = each.directory;
            } else if (!cell.failed) {
                return merge_error(
                    each.directory, "cell '" + cell.id + "' is finished here and in '" + from[cell.id] + "' too",
                    "merge takes every cell once: leave out one of the two directories, or remove the cell from one");
            }
        }
    std::map<std::uint64_t, std::string> seeds;
    for (const auto& [id, cell] : cells)
        if (const auto [known, is_new] = seeds.emplace(cell->seed, id); !is_new)
            return merge_error(from[id], "cells '" + id + "' and '" + known->second + "' have the same seed " +
                                             std::to_string(cell->seed) + ", so they are no independent renders");
    Experiment merged = experiments.front();
    merged.directory = output;
    merged.time = {};
    for (const Experiment& each : experiments) {
        merged.time.total += each.time.total;
        merged.time.render += each.time.render;
        merged.time.references += each.time.references;
    }
    if (Status s = merge_references(experiments, merged); !s) return s.error();
    MergeOutcome outcome;
    for (const auto& [id, cell] : cells) {
        const std::string source = cell->failed ? failed_file(from[id], id) : cell_directory(from[id], id);
        if (Status s = copy(source, cell->failed ? failed_file(output, id) : cell_directory(output, id)); !s)
            return s.error();
        ++(cell->failed ? outcome.failed : outcome.done);
    }
    fs::create_directories(output, failed);
    // Last: without it the directory is no results, so a merge that broke off is seen.
    if (Status s = write_experiment_files(merged); !s) return s.error();
    outcome.missing = merged.planned.size() - outcome.done - outcome.failed;
    return outcome;
}

}  // namespace raylex::experiments
