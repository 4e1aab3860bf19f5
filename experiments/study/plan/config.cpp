#include "experiments/study/plan/config.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "display/services/hash64.h"
#include "experiments/job/channel_tables.h"
#include "experiments/job/job_tables.h"
#include "experiments/job/parameter_check.h"
#include "experiments/job/passes/pass_plan.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/job/settings/setting.h"
#include "experiments/job/text/toml_text.h"
#include "experiments/study/plan/config_sections.h"
#include "experiments/study/plan/shell_places.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Reads a method's table into its settings. The caller reports the remaining keys.
void read_method_table(TomlTable& table, MethodRequest& method) {
    if (table.require("name", method.name)) check_short_name(table, "name", method.name);
    table.read("unbiased", method.unbiased);
    method.location = table.location();
    table.read("command", method.command);
    read_timeout(table, method.timeout);
    table.take("sweep");
    if (!method.command.empty()) return;
    table.read("beauty", method.settings.channels.beauty);
    read_method_settings(table, method.settings);
    read_effects(table, method.effects);
    read_entity(table, "integrator", method.settings.paths.integrator);
    read_entity(table, "sampler", method.settings.samples.sampler);
    read_entity(table, "filter", method.settings.film.filter);
    read_sample_filters(table, method.settings.channels);
    read_passes(table, "passes", method.passes);
}

Status check_method(const MethodRequest& method) {
    Job job;
    job.settings = method.settings;
    job.passes = method.passes;
    if (Status known = check_parameters(job); !known) return known;
    return begin_passes(job);
}

/// Moves the error of a swept value to the place of the sweep.
Error at_axis(Error error, const MethodRequest& method) {
    if (error.line != 0 || error.file.starts_with("--set") || method.sweep.empty()) return error;
    std::string message = error.message + " (swept by";
    for (const SweepAxis& axis : method.sweep) message += " " + axis.key;
    const SourceLocation& where = method.sweep.front().location;
    for (const SweepAxis& axis : method.sweep)
        if (error.message.find("'" + axis.key.substr(axis.key.rfind('.') + 1) + "'") != std::string::npos) {
            Error located = error_at(axis.location, error.message, error.hint);
            return located;
        }
    return error_at(where, message + ")", error.hint);
}

class ConfigReader {
  public:
    explicit ConfigReader(const ConfigText& text) : text_(text), source_(text.source()) {
        config_.file = text.file();
        config_.text = text.text();
        config_.overrides = text.overrides();
    }

    Result<ExperimentConfig> run() {
        auto table = text_.parse();
        if (!table) return table.error();
        std::ostringstream canonical;
        canonical << toml::toml_formatter(*table);
        config_.hash = hash_text(hash64(canonical.str()));
        TomlTable root(source_, *table, "the config");
        read_general(root);
        read_plugins(root, config_.file, config_.base);
        if (source_.error()) return *source_.error();
        for (const PluginRequest& plugin : config_.base.plugins)
            if (Status loaded = transport::load_plugin(plugin.file, plugin.location); !loaded) return loaded.error();
        read_settings_table(root, "color", config_.file, config_.base);
        read_scenes(root);
        read_channel_tables(root, config_.base);
        read_methods(root);
        read_budgets(root, config_.budgets);
        read_reference(root, config_);
        read_regions(root, config_);
        read_exclusions(root, config_);
        root.close();
        if (source_.error()) return *source_.error();
        for (std::size_t i = 0; i < config_.methods.size(); ++i)
            if (Status made = make_variants(i); !made) return made.error();
        for (std::size_t i = 0; i < config_.methods.size(); ++i) {
            if (config_.methods[i].name != config_.reference.method) continue;
            config_.reference.variant = config_.variants.size();
            config_.variants.push_back(
                {i, {}, config_.methods[i].settings, config_.methods[i].effects, config_.methods[i].passes, false});
        }
        if (Status checked = check_config(config_); !checked) return checked.error();
        return std::move(config_);
    }

  private:
    void read_general(TomlTable& root) {
        config_.name = fs::path(config_.file).stem().string();
        root.read("name", config_.name);
        std::int64_t number = 0;
        if (root.read("seed", number, 0, std::numeric_limits<std::int64_t>::max()))
            config_.seed = static_cast<std::uint64_t>(number);
        if (root.read("replicates", number, 1, 100'000)) config_.replicates = static_cast<unsigned>(number);
        read_setting(root, "render.threads", config_.base);
        read_setting(root, "render.isa", config_.base);
        std::string clock = "cpu";
        if (root.read("clock", clock) && clock != "wall" && clock != "cpu")
            source_.fail(root.location_of("clock"), "'clock' is '" + clock + "'; expected \"wall\" or \"cpu\"");
        config_.cpu_clock = clock == "cpu";
        Job timing;
        read_setting(root, "render.checkpoint", timing);
        config_.checkpoint_seconds = timing.checkpoint_seconds;
        read_timeout(root, config_.timeout);
    }

    void read_scenes(TomlTable& root) {
        for (const toml::table* each : root.take_tables("scene")) {
            TomlTable table(source_, *each, "a [[scene]] table");
            SceneRequest scene;
            scene.location = table.location();
            if (table.require("name", scene.name)) check_short_name(table, "name", scene.name);
            if (table.require("file", scene.job.scene_file)) {
                scene.job.scene_file = relative_to_job(config_.file, scene.job.scene_file);
                require_file(table, "file", scene.job.scene_file, "the scene");
            }
            if (table.read("reference", scene.reference_file)) {
                scene.reference_file = relative_to_job(config_.file, scene.reference_file);
                require_file(table, "reference", scene.reference_file, "the reference image");
            }
            read_setting(table, "render.resolution", scene.job);
            read_label_tables(table, scene.job);
            table.close();
            for (const SceneRequest& known : config_.scenes)
                if (known.name == scene.name)
                    source_.fail(table.location_of("name"),
                                 "the scene name '" + scene.name + "' is used twice; expected another");
            config_.scenes.push_back(std::move(scene));
        }
        if (config_.scenes.empty())
            source_.fail(SourceLocation{config_.file, 1, 1},
                         "the config names no scene; expected [[scene]] with name and file");
    }

    std::vector<SweepAxis> read_sweep(TomlTable& root) {
        std::vector<SweepAxis> axes;
        if (const toml::table* table = root.take_table("sweep")) {
            if (table->empty())
                source_.fail(root.location_of("sweep"),
                             "the sweep is empty; expected KEY = values, such as max_depth = [2, 4, 8]");
            read_axes(*table, "", axes);
        }
        return axes;
    }

    /// sampler.type = [...] is a nested table.
    void read_axes(const toml::table& table, const std::string& prefix, std::vector<SweepAxis>& axes) {
        for (const auto& [key, node] : table) {
            const std::string name = prefix + std::string(key.str());
            if (const toml::table* inner = node.as_table()) {
                read_axes(*inner, name + ".", axes);
                continue;
            }
            auto values = read_axis(source_, node, name);
            if (values) axes.push_back({name, std::move(*values), source_.location(node)});
            else source_.fail(values.error());
        }
    }

    void read_methods(TomlTable& root) {
        const std::vector<SweepAxis> shared = read_sweep(root);
        for (const toml::table* each : root.take_tables("method")) {
            TomlTable table(source_, *each, "a [[method]] table");
            MethodRequest method;
            read_method_table(table, method);
            if (method.timeout == 0) method.timeout = config_.timeout;
            method.sweep = shared;
            for (SweepAxis& own : read_sweep(table)) {
                std::erase_if(method.sweep, [&](const SweepAxis& axis) { return axis.key == own.key; });
                method.sweep.push_back(std::move(own));
            }
            // An external command sweeps only axes that it uses.
            if (!method.command.empty())
                std::erase_if(method.sweep,
                              [&](const SweepAxis& axis) { return !has_place(method.command, axis.key); });
            table.close();
            for (const MethodRequest& known : config_.methods)
                if (known.name == method.name)
                    source_.fail(table.location_of("name"),
                                 "the method name '" + method.name + "' is used twice; expected another");
            config_.methods.push_back(std::move(method));
        }
        if (config_.methods.empty())
            source_.fail(SourceLocation{config_.file, 1, 1},
                         "the config names no method; expected [[method]] with a name");
    }

    /// Makes all combinations of the method's axes; the last axis varies fastest.
    Status make_variants(std::size_t index) {
        const MethodRequest& method = config_.methods[index];
        std::size_t combinations = 1;
        for (const SweepAxis& axis : method.sweep) {
            combinations *= axis.values.size();
            if (combinations > 100'000)
                return error_at(axis.location,
                                "method '" + method.name + "' has more than 100000 combinations of settings");
        }
        for (std::size_t i = 0; i < combinations; ++i) {
            auto root = text_.parse();
            if (!root) return root.error();
            toml::table* table = named_table(*root, "method", method.name);
            Variant variant{index, {}, {}, {}};
            std::size_t left = i, below = combinations;
            for (const SweepAxis& axis : method.sweep) {
                below /= axis.values.size();
                const AxisValue& value = axis.values[left / below];
                left %= below;
                variant.settings.emplace_back(axis.key, value.text());
                if (method.command.empty()) ConfigText::put(*table, axis.key, value);
            }
            TomlSource source = text_.source();
            TomlTable reader(source, *table, "method '" + method.name + "'");
            MethodRequest read;
            read_method_table(reader, read);
            reader.close();
            if (source.error()) return at_axis(*source.error(), method);
            if (Status known = check_method(read); !known) return at_axis(known.error(), method);
            variant.render = std::move(read.settings);
            variant.effects = read.effects;
            variant.passes = std::move(read.passes);
            config_.variants.push_back(std::move(variant));
        }
        return success();
    }

    const ConfigText& text_;
    TomlSource source_;
    ExperimentConfig config_;
};

}  // namespace

Job ExperimentConfig::job(std::size_t scene, const Variant& variant) const {
    Job job = base;
    const Job& from = scenes[scene].job;
    job.job_file = file;
    job.scene_file = from.scene_file;
    job.label_rules = from.label_rules;
    job.settings.film.resolution = from.settings.film.resolution;
    job.effects = variant.effects;
    job.passes = variant.passes;
    job.layer_passes = !variant.passes.empty();
    const transport::RenderSettings& render = variant.render;
    job.settings.paths.integrator = render.paths.integrator;
    job.settings.samples.sampler = render.samples.sampler;
    job.settings.film.filter = render.film.filter;
    job.settings.paths.max_depth = render.paths.max_depth;
    job.settings.channels.beauty = render.channels.beauty;
    job.settings.paths.prune = render.paths.prune;
    job.settings.film.splat = render.film.splat;
    job.settings.labels.picked_lobes = render.labels.picked_lobes;
    job.settings.channels.sample_filters = render.channels.sample_filters;
    return job;
}

Result<ExperimentConfig> read_experiment_config(const std::string& path, const std::vector<std::string>& overrides) {
    auto content = read_toml_file(path, NamedBy::command_line, "a TOML config of an experiment");
    if (!content) return content.error();
    const ConfigText text(path, *std::move(content), overrides);
    return ConfigReader(text).run();
}

}  // namespace raylex::experiments
