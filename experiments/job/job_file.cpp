#include "experiments/job/job_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "experiments/job/channel_tables.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/job/toml_table.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t any_count = std::numeric_limits<std::int32_t>::max();

void read_files(TomlTable& root, const std::string& job_path, Job& job) {
    if (const toml::table* table = root.take_table("scene")) {
        TomlTable scene(root.source(), *table, "[scene]");
        if (scene.require("file", job.scene_file)) job.scene_file = beside_job(job_path, job.scene_file);
        scene.close();
    } else if (!root.has("scene")) {
        root.source().fail(SourceLocation{job_path, 1, 1},
                           "the job names no scene; expected [scene] with file = \"...\"");
    }
    if (const toml::table* table = root.take_table("output")) {
        TomlTable output(root.source(), *table, "[output]");
        if (output.read("file", job.output)) job.output = beside_job(job_path, job.output);
        if (output.read("preview", job.preview)) job.preview = beside_job(job_path, job.preview);
        if (output.read("stats", job.statistics)) job.statistics = beside_job(job_path, job.statistics);
        read_viewer(output, job.outputs);
        output.close();
    }
    if (const toml::table* table = root.take_table("color")) {
        TomlTable color(root.source(), *table, "[color]");
        if (color.read("ocio", job.ocio_config)) job.ocio_config = beside_job(job_path, job.ocio_config);
        color.read("rendering_space", job.rendering_space);
        color.read("display", job.display);
        color.read("view", job.view);
        color.read("texture_rules", job.texture_rules);
        color.close();
    }
}

void read_plugins(TomlTable& root, const std::string& job_path, Job& job) {
    std::vector<std::string> files;
    std::vector<SourceLocation> locations;
    if (!root.read("plugins", files, &locations)) return;
    for (std::size_t i = 0; i < files.size(); ++i)
        job.plugins.push_back({beside_job(job_path, files[i]), locations[i]});
}

void read_resolution(TomlTable& render, Job& job) {
    const toml::node* node = render.take("resolution");
    if (node == nullptr) return;
    const SourceLocation where = render.location_of("resolution");
    if (const auto* text = node->as_string()) {
        auto size = parse_resolution(text->get(), where);
        if (size) job.settings.resolution = *size;
        else render.source().fail(size.error());
        return;
    }
    const toml::array* list = node->as_array();
    const auto number = [&](std::size_t i) { return list->get(i)->value_exact<std::int64_t>().value_or(0); };
    const bool fits = list != nullptr && list->size() == 2 && number(0) >= 1 && number(0) <= 65536 && number(1) >= 1 &&
                      number(1) <= 65536;
    if (fits) job.settings.resolution = {{static_cast<int>(number(0)), static_cast<int>(number(1))}};
    else
        render.source().fail(
            where,
            "'resolution' in [render] is no pair of pixel counts; expected [width, height], each from 1 to 65536");
}

void read_render(TomlTable& root, Job& job) {
    const toml::table* table = root.take_table("render");
    if (table == nullptr) return;
    TomlTable render(root.source(), *table, "[render]");
    std::int64_t number = 0;
    if (render.read("spp", number, 1, any_count)) job.settings.samples_per_pixel = static_cast<std::uint64_t>(number);
    if (render.read("seed", number, 0, std::numeric_limits<std::int64_t>::max()))
        job.settings.seed = static_cast<std::uint64_t>(number);
    if (render.read("threads", number, 0, 4096)) job.settings.threads = static_cast<int>(number);
    if (render.read("max_depth", number, 0, any_count)) job.settings.max_depth = number;
    read_resolution(render, job);
    read_memory_limit(render, job.outputs);
    read_checkpoint(render, job);
    render.read("beauty", job.settings.beauty);
    render.read("isa", job.settings.isa);
    std::string mode;
    if (render.read("filter_mode", mode)) {
        job.settings.splat = mode == "splat";
        if (mode != "splat" && mode != "importance")
            root.source().fail(render.location_of("filter_mode"),
                               "'filter_mode' in [render] is '" + mode + "'; expected \"importance\" or \"splat\"");
    }
    std::string lobes;
    if (render.read("lobes", lobes)) {
        job.settings.picked_lobes = lobes == "picked";
        if (lobes != "picked" && lobes != "exact")
            root.source().fail(render.location_of("lobes"),
                               "'lobes' in [render] is '" + lobes + "'; expected \"exact\" or \"picked\"");
    }
    render.close();
}

/// [integrator], [sampler], [filter]: a type, and parameters that the object itself judges.
void read_entity(TomlTable& root, const char* key, std::optional<transport::SceneEntity>& entity) {
    const toml::table* table = root.take_table(key);
    if (table == nullptr) return;
    TomlTable reader(root.source(), *table, "[" + std::string(key) + "]");
    transport::SceneEntity result;
    if (!reader.require("type", result.type)) return;
    result.location = reader.location_of("type");
    result.parameters = reader.take_parameters();
    entity = std::move(result);
}

/// [[sample_filter]] and [[display_filter]], each list in its order.
void read_filters(TomlTable& root, Job& job) {
    for (const toml::table* table : root.take_tables("sample_filter")) {
        TomlTable reader(root.source(), *table, "a [[sample_filter]] table");
        transport::SceneEntity filter;
        if (!reader.require("type", filter.type)) continue;
        filter.location = reader.location_of("type");
        filter.parameters = reader.take_parameters();
        filter.parameters.location = filter.location;
        job.settings.sample_filters.push_back(std::move(filter));
    }
    for (const toml::table* table : root.take_tables("display_filter")) {
        TomlTable reader(root.source(), *table, "a [[display_filter]] table");
        ObjectRequest filter;
        if (!reader.require("type", filter.name)) continue;
        filter.parameters = reader.take_parameters();
        filter.parameters.location = reader.location_of("type");
        job.outputs.filters.push_back(std::move(filter));
    }
}

using Selector = transport::LabelRule::Selector;
struct SelectorKey {
    const char* key;
    Selector selector;
};

/// [[label]] may say holdout = true, beside a label or alone; light groups may not.
void read_rules(TomlTable& root, const char* kind, const char* target, std::initializer_list<SelectorKey> selectors,
                bool of_objects, Job& job) {
    for (const toml::table* table : root.take_tables(kind)) {
        TomlTable reader(root.source(), *table, "a [[" + std::string(kind) + "]] table");
        transport::LabelRule rule;
        rule.location = reader.location();
        int found = 0;
        std::string keys;
        for (const SelectorKey& each : selectors) {
            keys += (keys.empty() ? "" : ", ") + std::string(each.key);
            if (!reader.has(each.key)) continue;
            reader.require(each.key, rule.pattern);
            rule.selector = each.selector;
            rule.location = reader.location_of(each.key);
            ++found;
        }
        for (const SelectorKey& each : selectors) reader.take(each.key);
        bool holdout = false;
        if (of_objects && reader.read("holdout", holdout)) rule.holdout = holdout;
        rule.keeps_label = rule.holdout.has_value() && !reader.has(target);
        if (!rule.keeps_label) reader.require(target, rule.label);
        if (found != 1)
            root.source().fail(reader.location(), reader.description() + " has " + std::to_string(found) +
                                                      " selectors; expected exactly one of: " + keys);
        reader.close();
        job.label_rules.push_back(std::move(rule));
    }
}

}  // namespace

Result<Job> parse_job(const std::string& text, const std::string& path) {
    Job job;
    job.job_file = path;
    job.job_text = text;
    TomlSource source(path, text);
    toml::table table;
    try {
        table = toml::parse(std::string_view(text), std::string_view(path));
    } catch (const toml::parse_error& error) {
        source.fail(source.location(error.source()), "this is no valid TOML: " + std::string(error.description()));
        return *source.error();
    }
    TomlTable root(source, table, "the job");
    read_plugins(root, path, job);
    read_files(root, path, job);
    read_render(root, job);
    read_adaptive(root, job);
    read_entity(root, "integrator", job.settings.integrator);
    read_entity(root, "sampler", job.settings.sampler);
    read_entity(root, "filter", job.settings.filter);
    read_filters(root, job);
    read_channel_tables(root, job);
    read_output_tables(root, path, job.outputs);
    read_rules(root, "label", "label",
               {{"material", Selector::material}, {"mesh", Selector::mesh_file}, {"instance", Selector::instance}},
               true, job);
    read_rules(root, "light_group", "group",
               {{"light", Selector::light}, {"area_light_material", Selector::area_light_material}}, false, job);
    root.close();
    if (source.error()) return *source.error();
    return job;
}

Result<Job> read_job(const std::string& path) {
    std::error_code failed;
    if (fs::is_directory(path, failed)) return error_at({path, 0, 0}, "this is a directory; expected a TOML job file");
    std::ifstream file(path, std::ios::binary);
    if (!file) return error_at({path, 0, 0}, "cannot read the job file: " + std::string(std::strerror(errno)));
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    auto job = parse_job(text, path);
    if (!job) return job;
    for (const PluginRequest& plugin : job->plugins)
        if (Status loaded = transport::load_plugin(plugin.file, plugin.location); !loaded) return loaded.error();
    return job;
}

}  // namespace raylex::experiments
