// Loads plugins: shared libraries that register integrators, materials, filters, display drivers and the like.
#pragma once

#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/plugins/plugin_host.h"

namespace raylex::transport {

struct LoadedPlugin {
    std::string file;  ///< as it was asked for first
    std::string path;  ///< absolute, without symbolic links
    std::vector<PluginEntry> entries;
};

/// Loads the plugin and lets it register; one that is loaded already is left as it is. Single-threaded, before scenes
/// are built. Plugins stay loaded until the program ends.
///
/// Checked in this order, each an Error at `where` that names the file: it can be read; it is a shared library for this
/// machine; it carries a stamp; the stamp's raylex version, compiler, standard library, headers and layout are this
/// program's; only then the library is opened; it has an entry point; the entry point neither throws nor refuses. After
/// an Error the registries are as they were.
Status load_plugin(const std::string& file, const SourceLocation& where);

/// In the order they were loaded.
const std::vector<LoadedPlugin>& loaded_plugins();

}  // namespace raylex::transport
