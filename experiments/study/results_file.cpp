#include "experiments/study/results_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "display/output/atomic_file.h"
#include "display/services/parameters.h"
#include "experiments/study/results_json.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;
constexpr std::array budget_kinds{"samples", "seconds", "error"};

/// The fields of a planned cell.
void visit_plan(auto visit, StudyRun& run) {
    visit("id", run.id);
    visit("scene", run.scene);
    visit("method", run.method);
    visit("settings", run.settings);
    visit("budget_kind", run.budget_kind);
    visit("budget", run.budget);
    visit("replicate", run.replicate);
    visit("seed", run.seed);
}

/// A value as one of two texts.
struct OneOfTwo {
    bool& value;
    const char *if_true, *if_false;
};
void to_json(Json& json, const OneOfTwo& text) {
    json = text.value ? text.if_true : text.if_false;
}
void from_json(const Json& json, OneOfTwo& text) {
    text.value = json.get<std::string>() == text.if_true;
}

}  // namespace

static void to_json(Json& json, BudgetKind kind) {
    json = budget_kind_name(kind);
}
static void from_json(const Json& json, BudgetKind& kind) {
    const auto name = json.get<std::string>();
    for (std::size_t i = 0; i < budget_kinds.size(); ++i)
        if (name == budget_kinds[i]) kind = static_cast<BudgetKind>(i);
}

static void visit_fields(auto visit, StudyRun& run) {
    visit_plan(visit, run);
    visit("state", OneOfTwo{run.failed, "failed", "done"});
    visit.optional("reason", run.failure, run.failed);
    visit("samples_per_pixel", run.samples_per_pixel);
    visit.optional("guide_samples", run.guide_samples, run.guide_samples > 0);
    visit("wall_seconds", run.wall_seconds);
    visit("cpu_seconds", run.cpu_seconds);
    visit("phases", run.phases);
    visit("rays", run.rays);
    visit("invalid_samples", run.invalid_samples);
    visit("peak_memory_bytes", run.peak_memory_bytes);
    visit("splits", run.splits);
    visit.optional("part_of", run.part_of, !run.part_of.empty());
    visit.optional("first_sample", run.first_sample, !run.part_of.empty());
    visit.optional("end_sample", run.end_sample, !run.part_of.empty());
    visit.optional("parts", run.parts, run.parts > 0);
    visit("isa", run.isa);
    visit("threads", run.threads);
    visit.optional("machine", run.machine, !run.machine.empty());
    visit.optional("other_load", run.other_load, run.other_load >= 0);
    visit("warnings", run.warnings);
    visit.optional("omits", run.omits, !run.omits.empty());
    visit.optional("passes", run.passes, !run.passes.empty());
    visit.optional("files", run.files, !run.failed);
}

/// The fields of experiment.json before those of its run.
static void visit_fields(auto visit, Experiment& experiment) {
    visit("name", experiment.name);
    visit("config_hash", experiment.config_hash);
    visit("config_file", experiment.config_file);
    visit("overrides", experiment.overrides);
    visit("provenance", experiment.provenance);
    visit.optional("clock", OneOfTwo{experiment.cpu_clock, "cpu", "wall"}, true);
    visit("scenes", experiment.scenes);
    visit("methods", experiment.methods);
    visit("regions", experiment.regions);
    visit("partitions", experiment.partitions);
}

namespace {

/// Returns the path of a reference, relative to the results' directory if it is inside.
std::string path_within(const std::string& reference, const std::string& directory) {
    const fs::path relative = fs::path(reference).lexically_relative(directory);
    return relative.empty() || *relative.begin() == ".." ? fs::absolute(reference).string() : relative.string();
}

Json experiment_json(Experiment experiment) {
    for (SceneInfo& each : experiment.scenes)
        if (!each.reference.empty()) each.reference = path_within(each.reference, experiment.directory);
    Json json{{"format", experiment_format}};
    visit_fields(FieldWriter(json), experiment);
    json["runner"] = {
        {"total_seconds", experiment.time.total},         {"render_seconds", experiment.time.render},
        {"warm_up_seconds", experiment.time.warm_up},     {"reference_seconds", experiment.time.references},
        {"overhead_seconds", experiment.time.overhead()}, {"overhead_percent", experiment.time.overhead_percent()}};
    Json& runs = json["cells"] = Json::array();
    for (StudyRun& each : experiment.planned) visit_plan(FieldWriter(runs.emplace_back()), each);
    return json;
}

Experiment experiment_of(const Json& json, const std::string& directory) {
    Experiment experiment;
    experiment.directory = directory;
    visit_fields(FieldReader(json), experiment);
    for (SceneInfo& each : experiment.scenes)
        if (!each.reference.empty() && fs::path(each.reference).is_relative())
            each.reference = (fs::path(directory) / each.reference).string();
    const Json& runner = json.at("runner");
    experiment.time = {runner.at("total_seconds"), runner.at("render_seconds"), runner.value("warm_up_seconds", 0.0),
                       runner.at("reference_seconds")};
    for (const Json& each : json.at("cells")) visit_plan(FieldReader(each), experiment.planned.emplace_back());
    return experiment;
}

std::string text_of(const Json& json) {
    // Paths and messages may contain bytes that are not UTF-8. They are replaced; nothing is thrown.
    return json_text(json, 2) + "\n";
}

/// Reads a JSON file. `read` may throw for any invalid content.
template <class Read>
auto read_json(const std::string& path, const char* what, Read read) -> Result<decltype(read(Json()))> {
    const Result<Json> json = read_json_file(path, what);
    if (!json) return json.error();
    try {
        return read(*json);
    } catch (const Json::exception& error) {
        return error_at({path, 0, 0}, std::string("this is not ") + what + ", or it is damaged: " + error.what());
    }
}

std::string file_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Reads the parts of planned cells, ordered by name.
Status read_parts(Experiment& experiment) {
    std::set<std::string> planned;
    for (const StudyRun& each : experiment.planned) planned.insert(each.id);
    std::map<std::string, std::string> files;  // by name; finished rather than failed
    std::error_code failed;
    for (const char* folder : {"/failed", "/cells"})
        for (const fs::directory_entry& entry : fs::directory_iterator(experiment.directory + folder, failed)) {
            std::string name = entry.path().filename().string();
            if (folder == std::string("/failed") && name.ends_with(".json")) name.resize(name.size() - 5);
            if (!planned.contains(run_of_part(name))) continue;
            const std::string file =
                folder == std::string("/failed") ? entry.path().string() : entry.path().string() + "/cell.json";
            if (fs::exists(file, failed)) files[name] = file;
        }
    for (const auto& [name, file] : files) {
        auto part = read_run_file(file);
        if (!part) return part.error();
        if (part->id != name || part->part_of != run_of_part(name) || part->first_sample >= part->end_sample)
            return error_at({file, 0, 0}, "this is not part '" + name + "' of a cell");
        if (!part->failed) part->directory = run_directory(experiment.directory, name);
        experiment.parts.push_back(std::move(*part));
    }
    return success();
}

}  // namespace

std::string Experiment::load_warning() const {
    constexpr double idle = 0.05;       // background services of an idle system use one or two per cent
    double load = 0, seconds = 1e-300;  // weighted by wall time
    for (const StudyRun& run : runs) {
        if (run.failed || run.other_load < 0) continue;
        load += run.other_load * run.wall_seconds;
        seconds += run.wall_seconds;
    }
    if (load / seconds <= idle) return {};
    return "the machine was not idle: other processes used " + std::to_string(std::lround(100 * load / seconds)) +
           " % of its processors while cells were rendered; " +
           (cpu_clock ? "methods are compared by CPU time, which other processes increase through shared caches and "
                        "lower clock rates"
                      : "methods are compared by wall time, which other processes increase by different amounts; clock "
                        "= \"cpu\" compares by CPU time");
}

std::string budget_kind_name(BudgetKind kind) {
    return budget_kinds[static_cast<std::size_t>(kind)];
}

std::string experiment_file(const std::string& directory) {
    return directory + "/experiment.json";
}
std::string run_directory(const std::string& directory, const std::string& id) {
    return directory + "/cells/" + id;
}
std::string partial_directory(const std::string& directory, const std::string& id) {
    return run_directory(directory, id) + ".partial";
}
std::string failed_file(const std::string& directory, const std::string& id) {
    return directory + "/failed/" + id + ".json";
}

std::string run_of_part(const std::string& name) {
    const std::size_t dot = name.rfind(".p");
    if (dot == std::string::npos || dot == 0) return {};
    unsigned part = 0, parts = 0;
    const char* const end = name.data() + name.size();
    const auto [of, no_part] = std::from_chars(name.data() + dot + 2, end, part);
    if (no_part != std::errc() || end - of < 3 || of[0] != 'o' || of[1] != 'f') return {};
    const auto [last, no_parts] = std::from_chars(of + 2, end, parts);
    return no_parts == std::errc() && last == end && part >= 1 && part <= parts ? name.substr(0, dot) : std::string();
}

std::string run_text(const StudyRun& run) {
    return text_of(run);
}

Result<StudyRun> run_of_text(const std::string& text, const std::string& where) {
    try {
        return parse_json(text).get<StudyRun>();
    } catch (const Json::exception& error) {
        return error_at({where, 0, 0}, std::string("this is not a cell: ") + error.what());
    }
}

Status write_run_file(const std::string& path, const StudyRun& run, display::FileSync sync) {
    return display::write_text_file(path, run_text(run), sync);
}

Result<StudyRun> read_run_file(const std::string& path) {
    return read_json(path, "the cell.json of an experiment's cell",
                     [](const Json& json) { return json.get<StudyRun>(); });
}

Status write_experiment_files(const Experiment& experiment) {
    if (Status s = display::write_text_file(experiment.directory + "/config.toml", experiment.config_text); !s)
        return s;
    return display::write_text_file(experiment_file(experiment.directory), text_of(experiment_json(experiment)));
}

Result<Experiment> read_experiment(const std::string& directory) {
    const std::string path = experiment_file(directory);
    std::error_code failed;
    if (!fs::exists(path, failed))
        return error_at({directory, 0, 0},
                        "this is not a results directory of an experiment: it has no experiment.json");
    auto format =
        read_json(path, "an experiment.json", [](const Json& json) { return json.at("format").get<std::string>(); });
    if (!format) return format.error();
    if (*format != experiment_format)
        return error_at({path, 0, 0},
                        "the results have the format '" + *format + "'; expected '" + experiment_format + "'");
    auto experiment =
        read_json(path, "an experiment.json", [&](const Json& json) { return experiment_of(json, directory); });
    if (!experiment) return experiment;
    experiment->config_text = file_text(directory + "/config.toml");
    for (const StudyRun& planned : experiment->planned) {
        const std::string done = run_directory(directory, planned.id), broken = failed_file(directory, planned.id);
        const bool is_done = fs::exists(done + "/cell.json", failed);
        if (!is_done && !fs::exists(broken, failed)) {
            experiment->missing.push_back(planned.id);
            continue;
        }
        auto run = read_run_file(is_done ? done + "/cell.json" : broken);
        if (!run) return run.error();
        if (run->id != planned.id || run->seed != planned.seed)
            return error_at({is_done ? done + "/cell.json" : broken, 0, 0},
                            "this is cell '" + run->id + "' with seed " + std::to_string(run->seed) +
                                "; the plan has '" + planned.id + "' with seed " + std::to_string(planned.seed));
        if (is_done) run->directory = done;
        experiment->runs.push_back(std::move(*run));
    }
    if (Status s = read_parts(*experiment); !s) return s.error();
    return experiment;
}

}  // namespace raylex::experiments
