#include "transport/plugins/plugin_host.h"

#include <algorithm>
#include <new>
#include <type_traits>
#include <utility>

#include "display/services/channel_settings.h"
#include "geoaovs/geoaovs.h"

namespace raylex::transport {
namespace {

/// Wraps the factory: null pointers and exceptions become Errors, at the location of the first argument if it has one.
template <class Value, class First, class... Rest>
std::function<Result<Value>(First, Rest...)> guarded(std::function<Result<Value>(First, Rest...)> factory,
                                                     const std::string& what) {
    return [factory = std::move(factory), what](First first, Rest... rest) -> Result<Value> {
        SourceLocation place;
        if constexpr (requires { place = first.location; }) place = first.location;
        const auto failed = [&](const std::string& how) { return error_at(place, "the plugin's " + what + " " + how); };
        try {
            Result<Value> made = factory(std::forward<First>(first), std::forward<Rest>(rest)...);
            if constexpr (requires { *made == nullptr; })
                if (made && *made == nullptr) return failed("was a null pointer; expected an object or an Error");
            return made;
        } catch (const std::bad_alloc&) { throw; } catch (const std::exception& error) {
            return failed(std::string("could not be created: ") + error.what());
        } catch (...) { return failed("could not be created: it threw an object that is not a std::exception"); }
    };
}

}  // namespace

PluginHost::PluginHost(std::vector<PluginEntry> taken) : taken_(std::move(taken)) {}

template <class Factory>
void PluginHost::add(Registry<Factory>& registry, typename Registry<Factory>::Entry entry) {
    const auto same = [&](const PluginEntry& other) {
        return other.kind == registry.kind() && other.name == entry.name;
    };
    const std::string what = registry.kind() + " '" + entry.name + "'";
    constexpr bool is_channel = std::is_same_v<Factory, display::ChannelDefinition>;  // channels have no factory
    bool makes_something = true;
    if constexpr (!is_channel) makes_something = bool(entry.factory);
    if (entry.name.empty() || !makes_something) return refuse("its " + what + " has no name or no factory");
    if (std::any_of(taken_.begin(), taken_.end(), same))
        return refuse("another plugin has registered the " + what + " already");
    if (std::any_of(entries_.begin(), entries_.end(), same)) return refuse("it registers the " + what + " twice");
    entries_.push_back(
        {registry.kind(), entry.name, entry.help, entry.parameters, registry.find(entry.name) != nullptr});
    undo_.emplace_back([&registry, before = registry] { registry = before; });
    if constexpr (!is_channel) entry.factory = guarded(std::move(entry.factory), what);
    registry.add(std::move(entry));
}

void PluginHost::add_integrator(Registry<IntegratorFactory>::Entry entry) {
    add(integrator_registry(), std::move(entry));
}
void PluginHost::add_camera(Registry<CameraFactory>::Entry entry) {
    add(camera_registry(), std::move(entry));
}
void PluginHost::add_material(Registry<MaterialFactory>::Entry entry) {
    add(material_registry(), std::move(entry));
}
void PluginHost::add_pattern(Registry<PatternFactory>::Entry entry) {
    add(pattern_registry(), std::move(entry));
}
void PluginHost::add_medium(Registry<MediumFactory>::Entry entry) {
    add(medium_registry(), std::move(entry));
}
void PluginHost::add_shape(Registry<ShapeFactory>::Entry entry) {
    add(shape_registry(), std::move(entry));
}
void PluginHost::add_light(Registry<LightFactory>::Entry entry) {
    add(light_registry(), std::move(entry));
}
void PluginHost::add_pixel_filter(Registry<display::PixelFilterFactory>::Entry entry) {
    add(display::pixel_filter_registry(), std::move(entry));
}
void PluginHost::add_sample_filter(Registry<display::SampleFilterFactory>::Entry entry) {
    add(display::sample_filter_registry(), std::move(entry));
}
void PluginHost::add_display_filter(Registry<display::DisplayFilterFactory>::Entry entry) {
    add(display::display_filter_registry(), std::move(entry));
}
void PluginHost::add_display_driver(Registry<display::DisplayDriverFactory>::Entry entry) {
    add(display::display_driver_registry(), std::move(entry));
}

void PluginHost::add_channel(display::ChannelDefinition channel, std::string help) {
    if (channel.name == "beauty" || geoaovs::channel_definition(channel.name))
        return refuse("its channel '" + channel.name + "' is one of raylex's own; expected another name");
    if (channel.style != display::ChannelStyle::name)
        return refuse("its channel '" + channel.name + "' is a light path expression; expected a plain channel");
    channel.declared = true;
    std::string name = channel.name;
    help += std::string(" (channel of type ") + display::type_name(channel.type) + ")";
    add(display::channel_registry(), {std::move(name), std::move(help), {}, std::move(channel)});
}

LobeId PluginHost::add_lobe(const LobeKind& lobe) {
    if (const std::optional<LobeId> id = transport::add_lobe(lobe)) return *id;
    refuse("there is no id left for its lobe '" + std::string(lobe.name) + "': a program has at most 256 lobes");
    return 0;
}

void PluginHost::refuse(std::string reason) {
    if (!refusal_) refusal_ = std::move(reason);
}

void PluginHost::take_back() {
    for (; !undo_.empty(); undo_.pop_back()) undo_.back()();
    entries_.clear();
}

}  // namespace raylex::transport
