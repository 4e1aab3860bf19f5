#include "experiments/job/job_file.h"

#include <filesystem>
#include <utility>

#include "experiments/job/channel_tables.h"
#include "experiments/job/job_tables.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/job/settings/setting.h"
#include "experiments/job/text/toml_text.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::experiments {

Result<Job> parse_job(const std::string& text, const std::string& path) {
    Job job;
    job.job_file = path;
    job.job_text = text;
    TomlSource source(path, text);
    const auto table = parse_toml(text, path);
    if (!table) return table.error();
    TomlTable root(source, *table, "the job");
    read_plugins(root, path, job);
    if (!root.has("scene"))
        source.fail(SourceLocation{path, 1, 1}, "the job names no scene; expected [scene] with file = \"...\"");
    read_settings_table(root, "scene", path, job, [&](TomlTable& scene) {
        if (scene.require("file", job.scene_file)) job.scene_file = relative_to_job(path, job.scene_file);
    });
    for (const char* name : {"output", "color"}) read_settings_table(root, name, path, job);
    read_settings_table(root, "render", path, job, [&](TomlTable& render) { read_effects(render, job.effects); });
    read_adaptive(root, job);
    read_passes(root, "pass", job.passes);
    read_entity(root, "integrator", job.settings.paths.integrator);
    read_entity(root, "sampler", job.settings.samples.sampler);
    read_entity(root, "filter", job.settings.film.filter);
    read_sample_filters(root, job.settings.channels);
    job.outputs.filters = read_objects(root, "display_filter");
    read_channel_tables(root, job);
    read_output_tables(root, path, job);
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

Result<Job> read_scene_or_job(const std::string& path) {
    if (path.empty()) return error_at({}, "the scene's name is empty; expected a pbrt-v4 scene or a TOML job");
    if (std::filesystem::path(path).extension() == ".toml") return read_job(path);
    Job job;
    job.scene_file = path;
    return job;
}

}  // namespace raylex::experiments
