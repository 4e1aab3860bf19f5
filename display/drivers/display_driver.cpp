#include "display/drivers/display_driver.h"

#include <charconv>

#include "display/drivers/exr_driver.h"
#include "display/drivers/tev_driver.h"
#include "display/output/exr_layout.h"

namespace raylex::display {

namespace {

Result<Parameter> typed(const ParameterDescription& description, const std::string& text, const SourceLocation& where) {
    Parameter parameter;
    parameter.name = description.name;
    parameter.type = description.type;
    parameter.location = where;
    const auto wrong = [&](const char* expected) {
        return error_at(where, "parameter '" + description.name + "' is '" + text + "'; expected " + expected);
    };
    switch (description.type) {
        case ParameterType::boolean:
            if (text != "true" && text != "false") return wrong("true or false");
            parameter.booleans = {static_cast<std::uint8_t>(text == "true")};
            return parameter;
        case ParameterType::integer:
        case ParameterType::real: {
            double number = 0;
            const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
            if (failed != std::errc() || end != text.data() + text.size()) return wrong("a number");
            if (description.type == ParameterType::integer && number != static_cast<double>(static_cast<long>(number)))
                return wrong("a whole number");
            parameter.numbers = {number};
            return parameter;
        }
        default:
            parameter.strings = {text};
            return parameter;
    }
}

/// Cut at commas outside '...'; the quotes go.
std::vector<std::string> split_list(const std::string& text) {
    std::vector<std::string> items(1);
    bool quoted = false;
    for (const char c : text) {
        if (c == '\'') quoted = !quoted;
        else if (c == ',' && !quoted) items.emplace_back();
        else items.back() += c;
    }
    return items;
}

}  // namespace

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
    std::vector<std::string> known;
    for (const ParameterDescription& each : (*entry)->parameters) known.push_back(each.name);
    for (const Parameter* unused : parameters.unused()) {
        std::string list;
        for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
        const std::string near = nearest_name(unused->name, known);
        return error_at(unused->location,
                        "display driver '" + name + "' has no parameter '" + unused->name + "'; expected one of: " + list,
                        near.empty() ? std::string() : "did you mean '" + near + "'?");
    }
    return driver;
}

Result<DriverRequest> parse_driver_request(const std::string& text, const SourceLocation& where) {
    const std::size_t colon = text.find(':');
    DriverRequest request;
    request.name = text.substr(0, colon);
    request.parameters.location = where;
    auto entry = display_driver_registry().require(request.name, where);
    if (!entry) return entry.error();
    if (colon == std::string::npos || colon + 1 == text.size()) return request;
    for (const std::string& item : split_list(text.substr(colon + 1))) {
        const std::size_t equals = item.find('=');
        if (equals == std::string::npos || equals == 0)
            return error_at(where, "'" + item + "' is no parameter of a display driver; expected KEY=VALUE");
        const std::string key = item.substr(0, equals);
        // An unknown key goes in as it is: make_display_driver refuses it, as it does those of job files.
        ParameterDescription description{key, ParameterType::string, {}, {}};
        for (const ParameterDescription& each : (*entry)->parameters)
            if (each.name == key) description = each;
        auto parameter = typed(description, item.substr(equals + 1), where);
        if (!parameter) return parameter.error();
        request.parameters.parameters.push_back(std::move(*parameter));
    }
    return request;
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
