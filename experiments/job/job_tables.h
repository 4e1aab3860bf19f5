// Tables of a job that other files use too: the scenes and methods of an experiment.
#pragma once

#include <optional>
#include <string>

#include "experiments/job/job.h"
#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {

/// Reads plugins = ["a.so", "planted_error"]. Paths are relative to the folder of `job_path`.
void read_plugins(TomlTable& root, const std::string& job_path, Job& job);
/// Returns whether the name means a plugin of raylex: a plain name, neither a path nor lib*.so.
bool is_shipped_plugin(const std::string& name);
/// Returns the file of a plugin of raylex, in plugins/ beside the program or as installed.
std::string shipped_plugin(const std::string& name);
/// Reads prune, max_depth, filter_mode and lobes, the settings of light transport that are not objects.
void read_method_settings(TomlTable& table, transport::RenderSettings& settings);
/// Reads effects = { NAME = false, ... }: effects that are forced on or off.
void read_effects(TomlTable& table, transport::EffectChoices& effects);
/// Reads KEY = "type", or a table [KEY] with a type and parameters. The object itself checks the parameters.
void read_entity(TomlTable& root, const char* key, std::optional<transport::SceneEntity>& entity);
/// Reads [[sample_filter]] tables in their order.
void read_sample_filters(TomlTable& root, transport::ChannelSettings& channels);
/// Reads [[label]] and [[light_group]].
void read_label_tables(TomlTable& root, Job& job);

}  // namespace raylex::experiments
