#include "experiments/study/run/merge.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "display/services/parameters.h"
#include "experiments/study/file_records.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/cells/run_closer.h"
#include "experiments/study/run/cells/run_parts.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

Error merge_error(const std::string& directory, std::string message, std::string hint = {}) {
    return error_at({directory, 0, 0}, std::move(message), std::move(hint));
}

Status check_one_experiment(const Experiment& first, const Experiment& other) {
    if (first.config_hash != other.config_hash)
        return merge_error(other.directory,
                           "these results belong to another config (hash " + other.config_hash + ") than those in '" +
                               first.directory + "' (hash " + first.config_hash + ")",
                           "expected shards of one config, with the same --set");
    for (const SceneInfo& scene : first.scenes)
        for (const SceneInfo& same : other.scenes)
            if (scene.name == same.name && !scene.hash.empty() && !same.hash.empty() &&
                (scene.hash != same.hash || scene.width != same.width || scene.height != same.height))
                return merge_error(other.directory,
                                   "scene '" + scene.name + "' differs from the one in '" + first.directory + "'");
    return success();
}

/// Checks that no result is damaged.
Status check_files(const Experiment& experiment) {
    for (const auto* list : {&experiment.runs, &experiment.parts})
        for (const StudyRun& run : *list)
            if (const std::string damage = damage_of(run); !damage.empty())
                return merge_error(experiment.directory, "cell '" + run.id + "' is damaged: " + damage,
                                   "'raylex experiment resume' in that directory renders it again");
    for (const SceneInfo& scene : experiment.scenes)
        if (!scene.reference.empty())
            if (const std::string damage = damage_of_reference(scene.reference); !damage.empty())
                return merge_error(experiment.directory,
                                   "the reference of scene '" + scene.name + "' is damaged: " + damage,
                                   "remove its folder; 'raylex experiment resume' then renders it again");
    return success();
}

/// Returns a sort key for directories: their first cells. The order does not depend on the command line.
std::string order_key(const Experiment& experiment) {
    std::string key;
    for (const auto* list : {&experiment.runs, &experiment.parts})
        for (const StudyRun& each : *list) key += each.id + (each.failed ? "!" : "") + "\n";
    return key;
}

Status copy(const std::string& from, const std::string& to) {
    std::error_code failed;
    fs::create_directories(fs::path(to).parent_path(), failed);
    fs::copy(from, to, fs::copy_options::recursive, failed);
    return failed ? merge_error(to, "cannot copy '" + from + "' here: " + failed.message()) : success();
}

/// Copies the references of the experiments, each once.
Status merge_references(const std::vector<Experiment>& experiments, Experiment& merged) {
    for (SceneInfo& scene : merged.scenes) {
        for (const Experiment& each : experiments)
            for (const SceneInfo& same : each.scenes) {
                if (same.name != scene.name) continue;
                if (scene.hash.empty()) scene = same;  // it could not be loaded there
                if (same.reference.empty()) continue;
                if (scene.reference.empty()) scene = same;
                else if (fs::path(scene.reference).filename() != fs::path(same.reference).filename())
                    return merge_error(each.directory, "the reference of scene '" + scene.name + "' (" +
                                                           same.reference + ") differs from another one (" +
                                                           scene.reference + ")");
            }
        if (scene.reference.empty()) continue;
        // A reference in a shared cache stays there.
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

/// Returns the parts of cells that no directory has complete, by cell. A failed part counts only if no directory has it
/// finished.
Result<std::map<std::string, std::vector<const StudyRun*>>> parts_of(
    const std::vector<Experiment>& experiments, const std::map<std::string, const StudyRun*>& runs) {
    std::map<std::string, std::vector<const StudyRun*>> parts;
    std::set<std::string> done;
    for (const Experiment& each : experiments)
        for (const StudyRun& part : each.parts)
            if (!part.failed) done.insert(part.id);
    for (const Experiment& each : experiments)
        for (const StudyRun& part : each.parts) {
            if (const auto whole = runs.find(part.part_of); whole != runs.end() && !whole->second->failed)
                return merge_error(
                    each.directory,
                    "part '" + part.id + "' is here, but its cell is finished in '" + whole->second->directory + "'",
                    "every sample may occur once; leave out one of the two, or remove it");
            std::vector<const StudyRun*>& list = parts[part.part_of];
            const bool listed =
                std::any_of(list.begin(), list.end(), [&](const StudyRun* known) { return known->id == part.id; });
            if (!part.failed || !(done.contains(part.id) || listed)) list.push_back(&part);
        }
    for (auto& [id, list] : parts) {
        const auto& planned = experiments.front().planned;
        const auto run = std::find_if(planned.begin(), planned.end(),
                                      [&, &name = id](const StudyRun& each) { return each.id == name; });
        if (Status s = check_parts(*run, list); !s) return s.error();
    }
    return parts;
}

/// Checks that one program rendered all parts; otherwise they do not sum to one render.
Status check_one_program(const std::vector<Experiment>& experiments) {
    const Experiment* first = nullptr;
    const auto told = [](const Experiment& experiment, const char* what) {
        for (const auto& [name, value] : experiment.provenance)
            if (name == what) return value;
        return std::string();
    };
    for (const Experiment& each : experiments) {
        if (each.parts.empty()) continue;
        if (first == nullptr) first = &each;
        for (const char* what : {"revision", "compiler"})
            if (told(*first, what) != told(each, what))
                return merge_error(each.directory,
                                   std::string("its parts of cells come from another program (") + what + " " +
                                       told(each, what) + ") than those in '" + first->directory + "' (" +
                                       told(*first, what) + ")",
                                   "all parts of a cell must come from one program; whole cells need not");
    }
    return success();
}

/// Writes a cell merged from its parts, under its partial name until it is complete.
Status write_merged_run(const std::string& output, StudyRun run, const std::vector<const StudyRun*>& parts) {
    if (run.failed) {
        std::error_code failed;
        fs::create_directories(output + "/failed", failed);
        return write_run_file(failed_file(output, run.id), run);
    }
    const std::string partial = partial_directory(output, run.id);
    std::error_code failed;
    fs::create_directories(partial, failed);
    if (failed) return merge_error(partial, "cannot make this directory: " + failed.message());
    auto splits = write_merged_files(partial, run, parts);
    if (!splits) return splits.error();
    run.splits = std::move(*splits);
    return close_run_directory({run, partial, run_directory(output, run.id), {}});
}

/// All cells, each once; a finished cell takes precedence over a failed one.
struct MergedRuns {
    std::map<std::string, const StudyRun*> runs;
    std::map<std::string, std::string> from;  ///< cell -> results directory
};

Result<MergedRuns> cells_of(const std::vector<Experiment>& experiments) {
    MergedRuns merged;
    for (const Experiment& each : experiments)
        for (const StudyRun& run : each.runs) {
            const auto [known, is_new] = merged.runs.emplace(run.id, &run);
            if (is_new || known->second->failed) {
                known->second = &run;
                merged.from[run.id] = each.directory;
            } else if (!run.failed) {
                return merge_error(
                    each.directory, "cell '" + run.id + "' is finished here and also in '" + merged.from[run.id] + "'",
                    "every cell may occur once; leave out one of the two directories, or remove the cell from one");
            }
        }
    std::map<std::uint64_t, std::string> seeds;
    for (const auto& [id, run] : merged.runs)
        if (const auto [known, is_new] = seeds.emplace(run->seed, id); !is_new)
            return merge_error(merged.from[id], "cells '" + id + "' and '" + known->second + "' have the same seed " +
                                                    std::to_string(run->seed) +
                                                    ", so they are not independent renders");
    return merged;
}

/// Returns the description of the first experiment with the total time of all.
Experiment description_of_all(const std::vector<Experiment>& experiments, const std::string& output) {
    Experiment merged = experiments.front();
    merged.directory = output;
    merged.time = {};
    for (const Experiment& each : experiments) {
        merged.time.total += each.time.total;
        merged.time.render += each.time.render;
        merged.time.warm_up += each.time.warm_up;
        merged.time.references += each.time.references;
    }
    return merged;
}

}  // namespace

Result<MergeOutcome> merge_experiments(const std::vector<std::string>& directories, const std::string& output) {
    std::error_code failed;
    if (fs::exists(output, failed) && (!fs::is_directory(output, failed) || !fs::is_empty(output, failed)))
        return merge_error(output, "this directory exists already; expected a new one for -o");
    std::vector<Experiment> experiments;
    for (const std::string& each : directories) {
        auto read = read_experiment(each);
        if (!read) return read.error();
        experiments.push_back(std::move(*read));
        if (Status s = check_one_experiment(experiments.front(), experiments.back()); !s) return s.error();
        if (Status s = check_files(experiments.back()); !s) return s.error();
    }
    std::stable_sort(experiments.begin(), experiments.end(),
                     [](const Experiment& a, const Experiment& b) { return order_key(a) < order_key(b); });
    auto taken = cells_of(experiments);
    if (!taken) return taken.error();
    auto& [runs, from] = *taken;
    if (Status s = check_one_program(experiments); !s) return s.error();
    auto parts = parts_of(experiments, runs);
    if (!parts) return parts.error();
    Experiment merged = description_of_all(experiments, output);
    if (Status s = merge_references(experiments, merged); !s) return s.error();
    MergeOutcome outcome;
    for (const auto& [id, run] : runs) {
        if (parts->contains(id)) continue;  // it failed as a whole
        const std::string source = run->failed ? failed_file(from[id], id) : run_directory(from[id], id);
        if (Status s = copy(source, run->failed ? failed_file(output, id) : run_directory(output, id)); !s)
            return s.error();
        ++(run->failed ? outcome.failed : outcome.done);
    }
    for (const auto& [id, list] : *parts) {
        const auto planned = std::find_if(merged.planned.begin(), merged.planned.end(),
                                          [&, &name = id](const StudyRun& each) { return each.id == name; });
        const StudyRun run = merged_run(*planned, list);
        if (Status s = write_merged_run(output, run, list); !s) return s.error();
        ++(run.failed ? outcome.failed : outcome.done);
    }
    fs::create_directories(output, failed);
    // Written last: without it the directory is not a results directory, so an interrupted merge is noticed.
    if (Status s = write_experiment_files(merged); !s) return s.error();
    outcome.missing = merged.planned.size() - outcome.done - outcome.failed;
    return outcome;
}

}  // namespace raylex::experiments
