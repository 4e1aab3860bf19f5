#include "experiments/stability/suite/case_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "experiments/job/job_tables.h"
#include "experiments/job/parameter_check.h"
#include "experiments/job/text/toml_text.h"
#include "experiments/stability/probe.h"
#include "transport/integrators/integrator.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

void read_text(TomlTable& table, std::string_view key, CaseText& value) {
    // Plain numbers are allowed in place of formulas.
    if (const toml::node* node = table.take(key)) {
        value.location = table.location_of(key);
        if (const auto* text = node->as_string()) value.text = text->get();
        else if (const auto* whole = node->as_integer()) value.text = std::to_string(whole->get());
        else if (const auto* real = node->as_floating_point()) value.text = AxisValue{real->get()}.text();
        else table.source().fail(value.location, "'" + std::string(key) + "' is neither a number nor a formula");
    }
}

/// Reads with.NAME and vary.NAME, in the order of the text.
std::vector<CaseAxis> read_axes(TomlTable& table, const char* key, bool constant) {
    std::vector<CaseAxis> axes;
    const toml::table* values = table.take_table(key);
    if (values == nullptr) return axes;
    for (const auto& [name, node] : *values) {
        const std::string what = std::string(key) + "." + std::string(name.str());
        auto read = read_axis(table.source(), node, what);
        if (!read) {
            table.source().fail(read.error());
            continue;
        }
        if (constant && read->size() != 1)
            table.source().fail(table.source().location(node), "'" + what + "' has several values; expected one",
                                "several values belong in 'vary'");
        axes.push_back({std::string(name.str()), std::move(*read), table.source().location(node)});
    }
    std::stable_sort(axes.begin(), axes.end(), [](const CaseAxis& a, const CaseAxis& b) {
        return std::pair(a.location.line, a.location.column) < std::pair(b.location.line, b.location.column);
    });
    return axes;
}

template <class Value, std::size_t Count>
void read_choice(TomlTable& table, const char* key, const std::array<std::pair<const char*, Value>, Count>& choices,
                 Value& value) {
    std::string text, list;
    if (!table.read(key, text)) return;
    for (const auto& [name, each] : choices) {
        if (text == name) {
            value = each;
            return;
        }
        list += (list.empty() ? "" : ", ") + std::string(name);
    }
    table.source().fail(table.content_location_of(key),
                        "unknown " + std::string(key) + " '" + text + "'; expected one of: " + list);
}

void read_rows(TomlTable& table, std::vector<int>& rows) {
    const toml::node* node = table.take("rows");
    if (node == nullptr) return;
    const toml::array* list = node->as_array();
    bool whole = list != nullptr;
    for (std::size_t i = 0; whole && i < list->size(); ++i) {
        const auto* row = (*list)[i].as_integer();
        whole = row != nullptr && row->get() > 0 && row->get() < 10'000;
        if (whole) rows.push_back(static_cast<int>(row->get()));
    }
    if (!whole) table.source().fail(table.location_of("rows"), "'rows' is not a list of numbers of hard cases");
}

/// Reads against.NAME and against.integrator.
void read_against(TomlTable& table, SceneSubject& scene) {
    const bool compares = scene.measure == SceneMeasure::same_image || scene.measure == SceneMeasure::same_bits;
    if (table.has("against") != compares)
        table.source().fail(table.location_of(compares ? "measure" : "against"),
                            "'against' and the measures same_image and same_bits require each other");
    const toml::table* against = table.take_table("against");
    if (against == nullptr) return;
    TomlTable other(table.source(), *against, "against");
    if (other.read("integrator", scene.against_integrator)) {
        const auto known =
            transport::integrator_registry().require(scene.against_integrator, other.content_location_of("integrator"));
        if (!known) table.source().fail(known.error());
    }
    for (const auto& [name, node] : *against) {
        if (name.str() == "integrator") continue;
        CaseText value;
        read_text(other, name.str(), value);
        scene.against.emplace_back(std::string(name.str()), std::move(value));
    }
}

void read_scene(TomlTable& table, SceneSubject& scene) {
    table.read("scene", scene.scene.text);
    scene.scene.location = table.location_of("scene");
    constexpr std::array measures{std::pair("mean", SceneMeasure::mean),
                                  std::pair("largest", SceneMeasure::largest),
                                  std::pair("same_image", SceneMeasure::same_image),
                                  std::pair("same_bits", SceneMeasure::same_bits),
                                  std::pair("split", SceneMeasure::split),
                                  std::pair("outcome", SceneMeasure::outcome)};
    read_choice(table, "measure", measures, scene.measure);
    std::vector<SourceLocation> locations;
    table.read("integrators", scene.integrators, &locations);
    for (std::size_t i = 0; i < scene.integrators.size(); ++i) {
        const auto known = transport::integrator_registry().require(scene.integrators[i], locations[i]);
        if (!known) table.source().fail(known.error());
    }
    read_entity(table, "integrator", scene.settings.paths.integrator);
    if (scene.settings.paths.integrator && !scene.integrators.empty())
        table.source().fail(table.location_of("integrator"), "both 'integrator' and 'integrators'; expected one");
    read_entity(table, "sampler", scene.settings.samples.sampler);
    read_entity(table, "filter", scene.settings.film.filter);
    read_method_settings(table, scene.settings);
    read_sample_filters(table, scene.settings.channels);
    Job job;
    job.settings = scene.settings;
    if (const Status known = check_parameters(job); !known) table.source().fail(known.error());
    table.read("channel", scene.channel);
    std::int64_t component = -1;
    if (table.read("component", component, 0, 2)) scene.component = static_cast<int>(component);
    read_text(table, "spp", scene.samples);
    read_text(table, "seeds", scene.seeds);
    read_text(table, "threads", scene.threads);
    read_against(table, scene);
}

/// Checks that the values of --fast are among those of 'vary'.
void check_fast_axes(TomlTable& table, const StabilityCase& each) {
    const std::string hint = "'fast' must be a subset of the values in 'vary'";
    for (const CaseAxis& axis : each.fast) {
        const auto whole = std::find_if(each.varied.begin(), each.varied.end(),
                                        [&](const CaseAxis& other) { return other.name == axis.name; });
        if (whole == each.varied.end()) {
            table.source().fail(axis.location, "'fast." + axis.name + "' has no corresponding 'vary'", hint);
            continue;
        }
        for (const AxisValue& value : axis.values)
            if (std::none_of(whole->values.begin(), whole->values.end(),
                             [&](const AxisValue& other) { return other.text() == value.text(); }))
                table.source().fail(axis.location,
                                    "'fast." + axis.name + "' has " + value.text() + ", which 'vary' does not have",
                                    hint);
    }
}

void read_subject(TomlTable& table, StabilityCase& each) {
    if (table.has("scene") == table.has("probe")) {
        table.source().fail(table.location(), "a case has either a 'scene' or a 'probe', or is 'not_applicable'");
        return;
    }
    if (table.has("scene")) {
        read_scene(table, each.scene.emplace());
    } else if (table.require("probe", each.probe)) {
        const auto known = probe_registry().require(each.probe, table.content_location_of("probe"));
        if (probe_registry().entries().empty())
            table.source().fail(table.content_location_of("probe"),
                                "only raylex's own tests have probes; expected a 'scene'");
        else if (!known) table.source().fail(known.error());
    }
    each.constants = read_axes(table, "with", true);
    each.varied = read_axes(table, "vary", false);
    each.fast = read_axes(table, "fast", false);
    check_fast_axes(table, each);
    read_text(table, "expected", each.expected);
    read_text(table, "ulp_of", each.ulp_of);
    read_text(table, "tolerance", each.tolerance);
    if (each.tolerance.empty())
        table.source().fail(table.location(), "a case without 'tolerance'",
                            "terms such as \"4 se + 2 ulp + 1e-5 rel + 1e-9\", or \"exact\"");
    constexpr std::array comparisons{std::pair("equal", Comparison::equal), std::pair("at most", Comparison::at_most),
                                     std::pair("at least", Comparison::at_least)};
    read_choice(table, "holds", comparisons, each.comparison);
    table.require("reason", each.reason);
}

StabilityCase read_case(TomlSource& source, const toml::table& content) {
    TomlTable table(source, content, "a [[case]] table");
    StabilityCase each;
    each.location = table.location();
    table.require("name", each.name);
    read_rows(table, each.rows);
    table.require("symptom", each.symptom);
    table.read("source", each.source);
    table.read("slow", each.slow);
    if (!table.read("not_applicable", each.not_applicable)) read_subject(table, each);
    table.close();
    return each;
}

}  // namespace

Result<CaseFamily> read_case_file(const std::string& path) {
    auto text = read_toml_file(path, NamedBy::command_line, "a file of cases, or a folder of them");
    if (!text) return text.error();
    auto root_table = parse_toml(*text, path);
    if (!root_table) return root_table.error();
    TomlSource source(path, *text);
    TomlTable root(source, *root_table, "the file");
    CaseFamily family;
    family.file = path;
    family.name = fs::path(path).stem().string();
    root.require("title", family.title);
    root.read("about", family.about);
    root.read("picture", family.picture);
    Job job;
    read_plugins(root, path, job);
    if (source.error()) return *source.error();
    for (const PluginRequest& plugin : job.plugins)
        if (Status loaded = transport::load_plugin(plugin.file, plugin.location); !loaded) return loaded.error();
    for (const toml::table* each : root.take_tables("case")) family.cases.push_back(read_case(source, *each));
    root.close();
    if (source.error()) return *source.error();
    return family;
}

Result<std::vector<CaseFamily>> read_case_files(const std::vector<std::string>& paths) {
    std::vector<std::string> files;
    for (const std::string& path : paths) {
        std::error_code failed;
        if (!fs::is_directory(path, failed)) {
            files.push_back(path);
            continue;
        }
        const std::size_t before = files.size();
        for (const fs::directory_entry& entry : fs::directory_iterator(path, failed))
            if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
        std::sort(files.begin() + static_cast<std::ptrdiff_t>(before), files.end());
        if (files.size() == before) return error_at({path, 0, 0}, "no *.toml in this folder; expected files of cases");
    }
    std::vector<CaseFamily> families;
    std::set<std::string> names;
    for (const std::string& file : files) {
        auto family = read_case_file(file);
        if (!family) return family.error();
        for (const StabilityCase& each : family->cases)
            if (!names.insert(each.name).second)
                return error_at(each.location, "a second case '" + each.name + "'; expected every name once");
        families.push_back(std::move(*family));
    }
    return families;
}

}  // namespace raylex::experiments
