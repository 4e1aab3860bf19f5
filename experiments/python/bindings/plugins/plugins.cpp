// Loads C++ plugins, and registers the kinds of plugin that Python supports.
#include <pybind11/stl/filesystem.h>

#include "experiments/python/bindings/bindings.h"
#include "experiments/python/bindings/plugins/plugin_parts.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::python {

using namespace pybind11::literals;

void add_plugins(py::module_& module) {
    module.def(
        "load_plugin",
        [](const std::filesystem::path& file) {
            const std::string path = file.string();
            take(transport::load_plugin(path, {}));
            py::list entries;
            for (const transport::LoadedPlugin& plugin : transport::loaded_plugins())
                if (plugin.file == path)
                    for (const transport::PluginEntry& each : plugin.entries)
                        entries.append(py::make_tuple(each.kind, each.name, each.help));
            return entries;
        },
        "path"_a, "Loads a plugin written in C++ and returns what it registered: [(kind, name, help)].");
    add_textures(module);
    add_filters(module);
}

}  // namespace raylex::python
