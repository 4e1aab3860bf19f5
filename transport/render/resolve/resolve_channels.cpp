// Lists the channels of a render in the order of the frame buffer.
#include <set>

#include "display/services/channel_prefixes.h"
#include "display/services/channel_settings.h"
#include "transport/render/resolve/resolve_checks.h"

namespace raylex::transport {
namespace {

/// Completes the definition of a plain channel, as declared or by its known name.
Status resolve_plain(display::ChannelDefinition& channel, std::span<const display::ChannelDefinition> patterns) {
    auto known = named_channel(channel.name, patterns);
    if (channel.declared && !known) return success();
    if (!known) return known.error();
    if (channel.declared && channel.type != known->type)
        return error_at(display::location_of(channel),
                        "channel '" + channel.name + "' is declared with type " + display::type_name(channel.type) +
                            ", but a channel of that name has type " + display::type_name(known->type) +
                            "; expected another name or that type");
    known->statistics = channel.statistics;
    channel = *std::move(known);
    return success();
}

/// Lists beauty first if requested, then the settings' channels, then statistics; checks that names are unique and AOVs
/// known.
Status list_channels(const ChannelSettings& settings, std::span<const display::ChannelDefinition> patterns, bool splat,
                     bool splat_anywhere, JobChannels& channels) {
    std::set<std::string> names;
    if (settings.beauty) {
        display::ChannelDefinition beauty;
        beauty.name = "beauty";
        beauty.style = display::ChannelStyle::expression;
        beauty.expression = settings.takes.empty() ? "C.*" : settings.takes;
        beauty.space = "rendering colour space";
        beauty.statistics = !splat && !splat_anywhere;
        channels.beauty = 0;
        channels.list.push_back(beauty);
        names.insert(beauty.name);
    }
    const std::size_t shift = channels.list.size();
    for (display::ChannelDefinition channel : settings.list) {
        if (!names.insert(channel.name).second)
            return error_at({}, "the channel name '" + channel.name + "' is used twice; expected every name once");
        if (channel.style == display::ChannelStyle::name) {
            if (Status s = resolve_plain(channel, patterns); !s) return s;
            channels.written_by_plugins |= !geoaovs::channel_definition(channel.name);
        }
        if (splat_anywhere) channel.statistics = false;  // only layers can request statistics here
        for (std::size_t& index : channel.rest_of) index += shift;
        channels.list.push_back(std::move(channel));
    }
    if (channels.list.empty())
        return error_at({}, "nothing to render: no beauty and no channel; expected at least one");
    return display::apply_rules(settings.rules, channels.beauty, channels.list);
}

/// Makes the sample filters, which may add channels of their own.
Status make_sample_filters(const ChannelSettings& settings, JobChannels& channels) {
    for (const SceneEntity& entity : settings.sample_filters) {
        ParameterSet parameters = entity.parameters;
        if (parameters.location.file.empty()) parameters.location = entity.location;
        std::vector<display::ChannelDefinition> added;
        const auto add = [&](display::ChannelDefinition channel) -> Result<display::ChannelId> {
            for (const auto* list : {&channels.list, &added})
                for (const display::ChannelDefinition& known : *list)
                    if (known.name == channel.name)
                        return error_at(parameters.location, "sample filter '" + entity.type + "' adds the channel '" +
                                                                 channel.name +
                                                                 "', whose name is taken; expected another");
            added.push_back(std::move(channel));
            return static_cast<display::ChannelId>(channels.list.size() + added.size() - 1);
        };
        auto made = display::make_sample_filter(entity.type, parameters, {channels.list, channels.beauty, add});
        if (!made) return made.error();
        channels.filters.add(*std::move(made));
        channels.list.insert(channels.list.end(), added.begin(), added.end());
    }
    return success();
}

}  // namespace

Result<display::ChannelDefinition> named_channel(const std::string& name,
                                                 std::span<const display::ChannelDefinition> patterns) {
    std::vector<std::string> names;
    for (const display::ChannelDefinition& pattern : patterns) {
        if (pattern.name == name) return pattern;
        names.push_back(pattern.name);
    }
    if (const auto* entry = display::channel_registry().find(name)) return entry->factory;
    auto standard = geoaovs::channel_definition(name);
    if (standard) return standard;
    Error error = standard.error();
    const std::string near = nearest_name(name, names),
                      of_plugin = nearest_name(name, display::channel_registry().names());
    if (!near.empty()) error.hint = "did you mean '" + near + "', which a texture of the scene writes to?";
    else if (!of_plugin.empty()) error.hint = "did you mean '" + of_plugin + "', which a plugin declares?";
    return error;
}

Result<JobChannels> resolve_channels(const ChannelSettings& settings, const LabelSettings& labels,
                                     std::span<const display::ChannelDefinition> patterns,
                                     const ChosenIntegrator& chosen, bool splat) {
    JobChannels channels;
    channels.keeps_path_strings = labels.words.has_value();
    if (labels.picked_lobes) channels.attribution = display::LpeServices::Attribution::picked;
    if (Status s = list_channels(settings, patterns, splat, ResolvedJob::splats_anywhere(chosen), channels); !s)
        return s.error();
    if (Status s = make_sample_filters(settings, channels); !s) return s.error();
    if (Status s = display::add_layers(settings.layers, channels.list); !s) return s.error();
    if (Status s = display::add_statistics(settings.statistics, channels.list); !s) return s.error();
    return channels;
}

}  // namespace raylex::transport
