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
#include "experiments/job/text/json.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;
constexpr std::array budget_kinds{"samples", "seconds", "error"};

Json values_json(const NamedValues& values) {
    Json json = Json::object();
    for (const auto& [name, value] : values) json[name] = value;
    return json;
}

std::array<int, 4> crop_of(const Json& json) {
    return {whole(json.at(0)), whole(json.at(1)), whole(json.at(2)), whole(json.at(3))};
}

NamedValues values_of(const Json& json) {
    NamedValues values;
    for (const auto& [name, value] : json.items()) values.emplace_back(name, value.get<std::string>());
    return values;
}

/// Reads a number. JSON has no infinity, which is stored as null.
double number_of(const Json& json) {
    return json.is_null() ? HUGE_VAL : json.get<double>();
}

Json plan_json(const Cell& cell) {
    return {{"id", cell.id},
            {"scene", cell.scene},
            {"method", cell.method},
            {"settings", values_json(cell.settings)},
            {"budget_kind", budget_kind_name(cell.budget_kind)},
            {"budget", cell.budget},
            {"replicate", cell.replicate},
            {"seed", cell.seed}};
}

Cell planned_of(const Json& json) {
    Cell cell;
    cell.id = json.at("id");
    cell.scene = json.at("scene");
    cell.method = json.at("method");
    cell.settings = values_of(json.at("settings"));
    const std::string kind = json.at("budget_kind");
    for (std::size_t i = 0; i < budget_kinds.size(); ++i)
        if (kind == budget_kinds[i]) cell.budget_kind = static_cast<BudgetKind>(i);
    cell.budget = json.at("budget");
    cell.replicate = whole(json.at("replicate"));
    cell.seed = whole(json.at("seed"));
    return cell;
}

Json cell_json(const Cell& cell) {
    Json json = plan_json(cell);
    json["state"] = cell.failed ? "failed" : "done";
    if (cell.failed) json["reason"] = cell.failure;
    json["samples_per_pixel"] = cell.samples_per_pixel;
    json["wall_seconds"] = cell.wall_seconds;
    json["cpu_seconds"] = cell.cpu_seconds;
    Json phases = Json::array();
    for (const Phase& each : cell.phases)
        phases.push_back({{"name", each.name}, {"wall_seconds", each.wall_seconds}, {"cpu_seconds", each.cpu_seconds}});
    json["phases"] = phases;
    json["rays"] = cell.rays;
    json["invalid_samples"] = cell.invalid_samples;
    json["peak_memory_bytes"] = cell.peak_memory_bytes;
    Json splits = Json::array();
    for (const PartitionVerdict& each : cell.splits)
        splits.push_back({{"partition", each.partition},
                          {"holds", each.holds},
                          {"worst_relative_error", each.worst_relative_error}});
    json["splits"] = splits;
    if (!cell.part_of.empty()) {
        json["part_of"] = cell.part_of;
        json["first_sample"] = cell.first_sample;
        json["end_sample"] = cell.end_sample;
    }
    if (cell.parts > 0) json["parts"] = cell.parts;
    json["isa"] = cell.isa;
    json["threads"] = cell.threads;
    if (!cell.machine.empty()) json["machine"] = cell.machine;
    if (cell.other_load >= 0) json["other_load"] = cell.other_load;
    json["warnings"] = cell.warnings;
    Json omits = Json::array();
    for (const OmittedPathsInfo& each : cell.omits)
        omits.push_back({{"expression", each.expression}, {"dialect", each.dialect}});
    if (!cell.omits.empty()) json["omits"] = omits;
    Json files = Json::array();
    for (const FileRecord& each : cell.files)
        files.push_back({{"name", each.name}, {"bytes", each.bytes}, {"hash", each.hash}});
    if (!cell.failed) json["files"] = files;
    return json;
}

Cell cell_of(const Json& json) {
    Cell cell = planned_of(json);
    cell.failed = json.at("state") == "failed";
    if (cell.failed) cell.failure = json.at("reason");
    cell.samples_per_pixel = whole(json.at("samples_per_pixel"));
    cell.wall_seconds = json.at("wall_seconds");
    cell.cpu_seconds = json.at("cpu_seconds");
    for (const Json& each : json.at("phases"))
        cell.phases.push_back({each.at("name"), each.at("wall_seconds"), each.at("cpu_seconds")});
    cell.rays = whole(json.at("rays"));
    cell.invalid_samples = whole(json.at("invalid_samples"));
    cell.peak_memory_bytes = whole(json.at("peak_memory_bytes"));
    for (const Json& each : json.at("splits"))
        cell.splits.push_back({each.at("partition"), each.at("holds"), number_of(each.at("worst_relative_error"))});
    cell.part_of = json.value("part_of", std::string());
    cell.first_sample = whole(json.value("first_sample", Json(0)));
    cell.end_sample = whole(json.value("end_sample", Json(0)));
    cell.parts = whole(json.value("parts", Json(0)));
    cell.isa = json.at("isa");
    cell.threads = whole(json.at("threads"));
    cell.machine = json.value("machine", std::string());
    cell.other_load = json.value("other_load", -1.0);
    cell.warnings = json.at("warnings").get<std::vector<std::string>>();
    for (const Json& each : json.value("omits", Json::array()))
        cell.omits.push_back({each.at("expression"), each.at("dialect")});
    for (const Json& each : json.value("files", Json::array()))
        cell.files.push_back({each.at("name"), whole(each.at("bytes")), each.at("hash")});
    return cell;
}

Json scene_json(const SceneInfo& scene) {
    Json channels = Json::array();
    for (const ChannelInfo& each : scene.channels)
        channels.push_back(
            {{"name", each.name}, {"expression", each.expression}, {"dialect", each.dialect}, {"beauty", each.beauty}});
    Json json{{"name", scene.name},
              {"file", scene.file},
              {"hash", scene.hash},
              {"width", scene.width},
              {"height", scene.height},
              {"channels", channels},
              {"reference", scene.reference},
              {"reference_relative_error", scene.reference_relative_error},
              {"reference_method", scene.reference_method},
              {"reference_samples", scene.reference_samples}};
    if (!scene.reference_failure.empty()) json["reference_failure"] = scene.reference_failure;
    return json;
}

SceneInfo scene_of(const Json& json, const std::string& directory) {
    SceneInfo scene;
    scene.name = json.at("name");
    scene.file = json.at("file");
    scene.hash = json.at("hash");
    scene.width = whole(json.at("width"));
    scene.height = whole(json.at("height"));
    for (const Json& each : json.at("channels"))
        scene.channels.push_back({each.at("name"), each.at("expression"), each.at("dialect"), each.at("beauty")});
    scene.reference = json.at("reference");
    if (!scene.reference.empty() && fs::path(scene.reference).is_relative())
        scene.reference = (fs::path(directory) / scene.reference).string();
    scene.reference_relative_error = json.at("reference_relative_error");
    scene.reference_method = json.at("reference_method");
    scene.reference_samples = whole(json.at("reference_samples"));
    scene.reference_failure = json.value("reference_failure", std::string());
    return scene;
}

/// Makes the path of a reference inside the results relative to their current directory.
SceneInfo within(SceneInfo scene, const std::string& directory) {
    if (scene.reference.empty()) return scene;
    const fs::path relative = fs::path(scene.reference).lexically_relative(directory);
    scene.reference =
        relative.empty() || *relative.begin() == ".." ? fs::absolute(scene.reference).string() : relative.string();
    return scene;
}

Json experiment_json(const Experiment& experiment) {
    Json json;
    json["format"] = experiment_format;
    json["name"] = experiment.name;
    json["config_hash"] = experiment.config_hash;
    json["config_file"] = experiment.config_file;
    json["overrides"] = experiment.overrides;
    json["provenance"] = values_json(experiment.provenance);
    json["clock"] = experiment.cpu_clock ? "cpu" : "wall";
    Json scenes = Json::array(), methods = Json::array(), regions = Json::array(), partitions = Json::array(),
         cells = Json::array();
    for (const SceneInfo& each : experiment.scenes) scenes.push_back(scene_json(within(each, experiment.directory)));
    for (const MethodInfo& each : experiment.methods)
        methods.push_back({{"name", each.name},
                           {"integrator", each.integrator},
                           {"command", each.command},
                           {"unbiased", each.unbiased},
                           {"settings", values_json(each.settings)}});
    for (const Region& each : experiment.regions)
        regions.push_back(
            {{"name", each.name}, {"scene", each.scene}, {"crop", each.crop}, {"mask_file", each.mask_file}});
    for (const PartitionInfo& each : experiment.partitions)
        partitions.push_back({{"name", each.name}, {"of", each.of}, {"channels", each.channels}});
    for (const Cell& each : experiment.planned) cells.push_back(plan_json(each));
    json["scenes"] = scenes;
    json["methods"] = methods;
    json["regions"] = regions;
    json["partitions"] = partitions;
    json["runner"] = {
        {"total_seconds", experiment.time.total},         {"render_seconds", experiment.time.render},
        {"warm_up_seconds", experiment.time.warm_up},     {"reference_seconds", experiment.time.references},
        {"overhead_seconds", experiment.time.overhead()}, {"overhead_percent", experiment.time.overhead_percent()}};
    json["cells"] = cells;
    return json;
}

Experiment experiment_of(const Json& json, const std::string& directory) {
    Experiment experiment;
    experiment.directory = directory;
    experiment.name = json.at("name");
    experiment.config_hash = json.at("config_hash");
    experiment.config_file = json.at("config_file");
    experiment.overrides = json.at("overrides").get<std::vector<std::string>>();
    experiment.provenance = values_of(json.at("provenance"));
    experiment.cpu_clock = json.value("clock", std::string("wall")) == "cpu";
    for (const Json& each : json.at("scenes")) experiment.scenes.push_back(scene_of(each, directory));
    for (const Json& each : json.at("methods"))
        experiment.methods.push_back({each.at("name"), each.at("integrator"), each.at("command"), each.at("unbiased"),
                                      values_of(each.at("settings"))});
    for (const Json& each : json.at("regions"))
        experiment.regions.push_back(
            {each.at("name"), each.at("scene"), crop_of(each.at("crop")), each.at("mask_file")});
    for (const Json& each : json.at("partitions"))
        experiment.partitions.push_back(
            {each.at("name"), each.at("of"), each.at("channels").get<std::vector<std::string>>()});
    const Json& runner = json.at("runner");
    experiment.time = {runner.at("total_seconds"), runner.at("render_seconds"), runner.value("warm_up_seconds", 0.0),
                       runner.at("reference_seconds")};
    for (const Json& each : json.at("cells")) experiment.planned.push_back(planned_of(each));
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
    for (const Cell& each : experiment.planned) planned.insert(each.id);
    std::map<std::string, std::string> files;  // by name; finished rather than failed
    std::error_code failed;
    for (const char* folder : {"/failed", "/cells"})
        for (const fs::directory_entry& entry : fs::directory_iterator(experiment.directory + folder, failed)) {
            std::string name = entry.path().filename().string();
            if (folder == std::string("/failed") && name.ends_with(".json")) name.resize(name.size() - 5);
            if (!planned.contains(cell_of_part(name))) continue;
            const std::string file =
                folder == std::string("/failed") ? entry.path().string() : entry.path().string() + "/cell.json";
            if (fs::exists(file, failed)) files[name] = file;
        }
    for (const auto& [name, file] : files) {
        auto part = read_cell_file(file);
        if (!part) return part.error();
        if (part->id != name || part->part_of != cell_of_part(name) || part->first_sample >= part->end_sample)
            return error_at({file, 0, 0}, "this is not part '" + name + "' of a cell");
        if (!part->failed) part->directory = cell_directory(experiment.directory, name);
        experiment.parts.push_back(std::move(*part));
    }
    return success();
}

}  // namespace

std::string Experiment::load_warning() const {
    constexpr double idle = 0.05;       // background services of an idle system use one or two per cent
    double load = 0, seconds = 1e-300;  // weighted by wall time
    for (const Cell& cell : cells) {
        if (cell.failed || cell.other_load < 0) continue;
        load += cell.other_load * cell.wall_seconds;
        seconds += cell.wall_seconds;
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
std::string cell_directory(const std::string& directory, const std::string& id) {
    return directory + "/cells/" + id;
}
std::string partial_directory(const std::string& directory, const std::string& id) {
    return cell_directory(directory, id) + ".partial";
}
std::string failed_file(const std::string& directory, const std::string& id) {
    return directory + "/failed/" + id + ".json";
}

std::string cell_of_part(const std::string& name) {
    const std::size_t dot = name.rfind(".p");
    if (dot == std::string::npos || dot == 0) return {};
    unsigned part = 0, parts = 0;
    const char* const end = name.data() + name.size();
    const auto [of, no_part] = std::from_chars(name.data() + dot + 2, end, part);
    if (no_part != std::errc() || end - of < 3 || of[0] != 'o' || of[1] != 'f') return {};
    const auto [last, no_parts] = std::from_chars(of + 2, end, parts);
    return no_parts == std::errc() && last == end && part >= 1 && part <= parts ? name.substr(0, dot) : std::string();
}

std::string cell_text(const Cell& cell) {
    return text_of(cell_json(cell));
}

Result<Cell> cell_of_text(const std::string& text, const std::string& where) {
    try {
        return cell_of(parse_json(text));
    } catch (const Json::exception& error) {
        return error_at({where, 0, 0}, std::string("this is not a cell: ") + error.what());
    }
}

Status write_cell_file(const std::string& path, const Cell& cell, display::FileSync sync) {
    return display::write_text_file(path, cell_text(cell), sync);
}

Result<Cell> read_cell_file(const std::string& path) {
    return read_json(path, "the cell.json of an experiment's cell", cell_of);
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
    for (const Cell& planned : experiment->planned) {
        const std::string done = cell_directory(directory, planned.id), broken = failed_file(directory, planned.id);
        const bool is_done = fs::exists(done + "/cell.json", failed);
        if (!is_done && !fs::exists(broken, failed)) {
            experiment->missing.push_back(planned.id);
            continue;
        }
        auto cell = read_cell_file(is_done ? done + "/cell.json" : broken);
        if (!cell) return cell.error();
        if (cell->id != planned.id || cell->seed != planned.seed)
            return error_at({is_done ? done + "/cell.json" : broken, 0, 0},
                            "this is cell '" + cell->id + "' with seed " + std::to_string(cell->seed) +
                                "; the plan has '" + planned.id + "' with seed " + std::to_string(planned.seed));
        if (is_done) cell->directory = done;
        experiment->cells.push_back(std::move(*cell));
    }
    if (Status s = read_parts(*experiment); !s) return s.error();
    return experiment;
}

}  // namespace raylex::experiments
