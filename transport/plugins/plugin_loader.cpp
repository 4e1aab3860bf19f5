#include "transport/plugins/plugin_loader.h"

#include <dlfcn.h>

#include <exception>
#include <filesystem>
#include <system_error>
#include <utility>

#include "transport/plugins/plugin_file.h"

namespace raylex::transport {
namespace {

std::vector<LoadedPlugin>& plugins() {
    static std::vector<LoadedPlugin> list;
    return list;
}

std::string last_loader_error() {
    const char* text = dlerror();
    return text != nullptr ? text : "no reason given";
}

using EntryPoint = void (*)(PluginHost&);

}  // namespace

const std::vector<LoadedPlugin>& loaded_plugins() {
    return plugins();
}

Status load_plugin(const std::string& file, const SourceLocation& where) {
    auto stamp = read_plugin_stamp(file, where);
    if (!stamp) return stamp.error();
    if (Status fits = check_plugin_stamp(*stamp, file, where); !fits) return fits;
    std::error_code failed;
    const std::string path = std::filesystem::canonical(file, failed).string();
    if (failed) return error_at(where, "cannot read plugin '" + file + "': " + failed.message());
    for (const LoadedPlugin& each : plugins())
        if (each.path == path) return success();

    // All symbols are bound now, so that a missing symbol is an error here instead of a crash later.
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr)
        return error_at(where, "plugin '" + file + "' cannot be loaded: " + last_loader_error(),
                        "a missing raylex symbol was declared but never defined, or this program exports no symbols "
                        "(raylex_plugin_host)");
    const auto entry = reinterpret_cast<EntryPoint>(dlsym(library, "raylex_register_plugin"));
    if (entry == nullptr)
        return error_at(where, "plugin '" + file + "' has no entry point; expected RAYLEX_PLUGIN(host) { ... }");

    std::vector<PluginEntry> taken;
    for (const LoadedPlugin& each : plugins()) taken.insert(taken.end(), each.entries.begin(), each.entries.end());
    PluginHost host(std::move(taken));
    try {
        entry(host);
    } catch (const std::exception& error) {
        host.refuse(std::string("it threw while registering: ") + error.what());
    } catch (...) { host.refuse("it threw an object that is not a std::exception while registering"); }
    if (host.refusal()) {
        host.take_back();
        return error_at(where, "plugin '" + file + "' cannot be used: " + *host.refusal());
    }
    if (host.entries().empty())
        return error_at(where, "plugin '" + file + "' registered nothing; expected at least one object");
    plugins().push_back({file, path, host.entries()});
    return success();
}

}  // namespace raylex::transport
