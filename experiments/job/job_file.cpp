#include "experiments/job/job_file.h"

#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "experiments/job/channel_tables.h"
#include "experiments/job/job_tables.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/job/text/toml_text.h"
#include "experiments/program/console.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t any_count = std::numeric_limits<std::int32_t>::max();

void read_files(TomlTable& root, const std::string& job_path, Job& job) {
    if (const toml::table* table = root.take_table("scene")) {
        TomlTable scene(root.source(), *table, "[scene]");
        if (scene.require("file", job.scene_file)) job.scene_file = beside_job(job_path, job.scene_file);
        std::string missing;
        if (scene.read("missing", missing)) {
            if (auto parsed = parse_missing(missing, scene.location_of("missing"))) job.missing = *parsed;
            else root.source().fail(scene.location_of("missing"), parsed.error().message);
        }
        scene.close();
    } else if (!root.has("scene")) {
        root.source().fail(SourceLocation{job_path, 1, 1},
                           "the job names no scene; expected [scene] with file = \"...\"");
    }
    if (const toml::table* table = root.take_table("output")) {
        TomlTable output(root.source(), *table, "[output]");
        if (output.read("file", job.output)) job.output = beside_job(job_path, job.output);
        if (output.read("preview", job.preview)) job.preview = beside_job(job_path, job.preview);
        if (output.read("stats", job.statistics) && !is_standard_output(job.statistics))
            job.statistics = beside_job(job_path, job.statistics);
        read_viewer(output, job.outputs);
        output.close();
    }
}

/// Reads crop = [x0, y0, x1, y1]
void read_crop(TomlTable& render, Job& job) {
    const toml::node* node = render.take("crop");
    if (node == nullptr) return;
    std::string text;
    if (const toml::array* list = node->as_array())
        for (const toml::node& each : *list)
            text += (text.empty() ? "" : ",") + std::to_string(each.value_exact<std::int64_t>().value_or(-1));
    auto crop = parse_crop(text, render.location_of("crop"));
    if (crop) job.settings.film.crop = *crop;
    else
        render.source().fail(
            render.location_of("crop"),
            "'crop' in [render] is not a part of an image; expected [x0, y0, x1, y1] in pixels with x0 < x1 "
            "and y0 < y1");
}

void read_render(TomlTable& root, Job& job) {
    const toml::table* table = root.take_table("render");
    if (table == nullptr) return;
    TomlTable render(root.source(), *table, "[render]");
    std::int64_t number = 0;
    if (render.read("spp", number, 1, any_count)) job.settings.samples.per_pixel = static_cast<std::uint64_t>(number);
    if (render.read("seed", number, 0, std::numeric_limits<std::int64_t>::max()))
        job.settings.samples.seed = static_cast<std::uint64_t>(number);
    if (render.read("threads", number, 0, 4096)) job.settings.machine.threads = static_cast<int>(number);
    read_resolution(render, job);
    read_crop(render, job);
    read_memory_limit(render, job.outputs);
    read_time(render, job);
    read_checkpoint(render, job);
    read_buckets(render, job);
    render.read("beauty", job.settings.channels.beauty);
    render.read("isa", job.settings.machine.isa);
    read_method_settings(render, job.settings);
    read_effects(render, job.effects);
    render.close();
}

/// Reads [[display_filter]] tables in their order.
void read_display_filters(TomlTable& root, Job& job) {
    for (const toml::table* table : root.take_tables("display_filter")) {
        TomlTable reader(root.source(), *table, "a [[display_filter]] table");
        ObjectRequest filter;
        if (!reader.require("type", filter.name)) continue;
        filter.parameters = reader.take_parameters();
        filter.parameters.location = reader.location_of("type");
        job.outputs.filters.push_back(std::move(filter));
    }
}

}  // namespace

Result<Job> parse_job(const std::string& text, const std::string& path) {
    Job job;
    job.job_file = path;
    job.job_text = text;
    TomlSource source(path, text);
    const auto table = parse_toml(text, path);
    if (!table) return table.error();
    TomlTable root(source, *table, "the job");
    read_plugins(root, path, job);
    read_files(root, path, job);
    read_color_table(root, path, job);
    read_render(root, job);
    read_adaptive(root, job);
    read_entity(root, "integrator", job.settings.paths.integrator);
    read_entity(root, "sampler", job.settings.samples.sampler);
    read_entity(root, "filter", job.settings.film.filter);
    read_sample_filters(root, job.settings.channels);
    read_display_filters(root, job);
    read_channel_tables(root, job);
    read_output_tables(root, path, job.outputs);
    read_label_tables(root, job);
    root.close();
    if (source.error()) return *source.error();
    return job;
}

Result<Job> read_job(const std::string& path) {
    const auto text = read_toml_file(path, NamedBy::command_line, "a TOML job");
    if (!text) return text.error();
    auto job = parse_job(*text, path);
    if (!job) return job;
    for (const PluginRequest& plugin : job->plugins)
        if (Status loaded = transport::load_plugin(plugin.file, plugin.location); !loaded) return loaded.error();
    return job;
}

}  // namespace raylex::experiments
