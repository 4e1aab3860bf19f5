// Loads plugins: shared libraries that register integrators, materials, filters, display drivers and the like.
#pragma once

#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/plugins/plugin_host.h"

namespace raylex::transport {

struct LoadedPlugin {
    std::string file;  ///< the file name of the first request
    std::string path;  ///< absolute, without symbolic links
    std::vector<PluginEntry> entries;
};

/// Loads the plugin and lets it register its objects; a plugin that is already loaded is left unchanged.
/// Single-threaded, before scenes are built. Plugins stay loaded until the program ends.
///
/// Checks in this order, each an Error at `where` that names the file: it can be read; it is a shared library for this
/// machine; it contains a stamp; the stamp's raylex version, compiler, standard library, headers and layout match this
/// program. Only then is the library opened: it has an entry point, which neither throws nor refuses. After an Error
/// the registries are unchanged.
Status load_plugin(const std::string& file, const SourceLocation& where);

/// All loaded plugins in the order of loading.
const std::vector<LoadedPlugin>& loaded_plugins();

}  // namespace raylex::transport
