// A plugin that fails in the way given by the environment variable MISBEHAVIOUR.
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "transport/plugins/plugin.h"

RAYLEX_PLUGIN(host) {
    using namespace raylex;
    const char* requested = std::getenv("MISBEHAVIOUR");
    const std::string kind = requested != nullptr ? requested : "";
    const auto factory = [kind](const ParameterSet&,
                                const display::DriverContext&) -> Result<std::unique_ptr<display::DisplayDriver>> {
        if (kind == "null-driver") return std::unique_ptr<display::DisplayDriver>();
        if (kind == "number-driver") throw 42;
        return error_at({}, "never made");
    };
    if (kind == "nothing") return;
    // An object that must not stay registered when the plugin is refused.
    host.add_display_driver({"halfway", "registered before the plugin fails", {}, factory});
    if (kind == "exception") throw std::runtime_error("no licence for this machine");
    if (kind == "number") throw 42;
    if (kind == "refusal") host.refuse("it needs a graphics card");
    if (kind == "twice") host.add_display_driver({"halfway", "once more", {}, factory});
    if (kind == "shadow") host.add_display_driver({"exr", "in the place of the in-tree driver", {}, factory});
}
