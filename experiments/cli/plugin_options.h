// --plugin, an option of every command that reads scenes.
#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "lpe/result.h"

namespace raylex::experiments {

CLI::Option* add_plugin_option(CLI::App& command, std::vector<std::string>& files);

/// Loads the files of --plugin, in order.
Status load_plugins(const std::vector<std::string>& files);

}  // namespace raylex::experiments
