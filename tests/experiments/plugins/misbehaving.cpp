// A plugin that does not work, in the way that MISBEHAVIOUR says.
#include <stdexcept>

#include "transport/plugins/plugin.h"

#if MISBEHAVIOUR == 5
extern "C" void raylex_not_defined_anywhere();
#endif

RAYLEX_PLUGIN(host) {
    using namespace raylex;
    const auto factory = [](const ParameterSet&, const display::DriverContext&) -> Result<std::unique_ptr<display::DisplayDriver>> {
        return error_at({}, "never made");
    };
    // Something that must not stay behind when the plugin is refused.
    host.add_display_driver({"halfway", "registered before the plugin fails", {}, factory});
#if MISBEHAVIOUR == 1
    throw std::runtime_error("no licence for this machine");
#elif MISBEHAVIOUR == 2
    throw 42;
#elif MISBEHAVIOUR == 3
    host.refuse("it needs a graphics card");
#elif MISBEHAVIOUR == 4
    host.add_display_driver({"halfway", "once more", {}, factory});
#elif MISBEHAVIOUR == 5
    raylex_not_defined_anywhere();
#elif MISBEHAVIOUR == 6
    host.add_display_driver({"exr", "in the place of the in-tree driver", {}, factory});
#endif
}
