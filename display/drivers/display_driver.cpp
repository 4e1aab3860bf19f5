#include "display/drivers/display_driver.h"

#include "display/drivers/exr_driver.h"
#include "display/drivers/tev_driver.h"
#include "display/output/writer/exr_layout.h"

namespace raylex::display {

Registry<DisplayDriverFactory>& display_driver_registry() {
    static Registry<DisplayDriverFactory> registry = [] {
        Registry<DisplayDriverFactory> drivers("display driver");
        drivers.add(exr_driver_entry());
        drivers.add(tev_driver_entry());
        return drivers;
    }();
    return registry;
}

Result<std::unique_ptr<DisplayDriver>> make_display_driver(const std::string& name, const ParameterSet& parameters,
                                                           const DriverContext& context) {
    auto entry = display_driver_registry().require(name, parameters.location);
    if (!entry) return entry.error();
    auto driver = (*entry)->factory(parameters, context);
    if (!driver) return driver;
    if (Status used = check_all_used(parameters, (*entry)->parameters, "display driver", name); !used)
        return used.error();
    return driver;
}

Result<DriverRequest> parse_driver_request(const std::string& text, const SourceLocation& where) {
    return parse_object_request(text, display_driver_registry(), "display driver", where);
}

std::vector<DriverLayer> driver_layers(std::span<const ChannelDefinition> channels, ChannelId beauty) {
    std::vector<DriverLayer> layers;
    for (const PlannedPart& part : plan_parts(channels, beauty, {})) {
        const bool is_beauty = part.channel == beauty;
        const ChannelDefinition& channel = channels[static_cast<std::size_t>(part.channel)];
        layers.push_back({is_beauty ? "" : channel.name, part.channel, channel.type, part.planes, part.alpha});
    }
    return layers;
}

}  // namespace raylex::display
