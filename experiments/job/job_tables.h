// The tables of a job that other files have too: an experiment's scenes and methods are read by these.
#pragma once

#include <optional>
#include <string>

#include "experiments/job/job.h"
#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {

/// plugins = ["a.so", "planted_error"]; paths count from the folder of `job_path`.
void read_plugins(TomlTable& root, const std::string& job_path, Job& job);
/// A plugin by its name alone, neither a path nor lib*.so: one that comes with the program.
bool is_shipped_plugin(const std::string& name);
/// Its file: in plugins/ beside the program, or where the installed program has it.
std::string shipped_plugin(const std::string& name);
/// [color].
void read_color_table(TomlTable& root, const std::string& job_path, Job& job);
/// resolution = [width, height] or "WxH".
void read_resolution(TomlTable& table, Job& job);
/// max_depth, filter_mode, lobes: what changes how light is found, beside the objects below.
void read_method_settings(TomlTable& table, transport::RenderSettings& settings);
/// effects = { NAME = false, ... }: which are forced on or off.
void read_effects(TomlTable& table, transport::EffectChoices& effects);
/// KEY = "type", or a table [KEY] with a type and parameters that the object itself judges.
void read_entity(TomlTable& root, const char* key, std::optional<transport::SceneEntity>& entity);
/// [[sample_filter]], in their order.
void read_sample_filters(TomlTable& root, transport::ChannelSettings& channels);
/// [[label]] and [[light_group]].
void read_label_tables(TomlTable& root, Job& job);

}  // namespace raylex::experiments
