// Settings of layers.
#include <algorithm>

#include "experiments/job/settings/kinds.h"
#include "geoaovs/geoaovs.h"

namespace raylex::experiments {
namespace {

using enum RenderSetting::Use;

/// The names of all geometric AOVs.
std::string aov_names() {
    std::string names;
    for (const std::string& name : geoaovs::channel_names()) names += (names.empty() ? "" : ", ") + name;
    return names;
}

/// Adds the name to a flag's location: "--aov Nn".
SourceLocation named(SourceLocation where, const std::string& name) {
    if (where.line == 0) where.file += " " + name;
    return where;
}

Status add_aov(Job& job, const std::string& name, const SourceLocation& where) {
    job.aovs.push_back({name, named(where, name)});
    return success();
}

Status add_declared(Job& job, const std::string& text, const SourceLocation& where) {
    const SourceLocation place = named(where, text);
    auto channel = display::parse_declared_channel(text, place);
    if (!channel) return channel.error();
    channel->origin = place.file;
    job.declared.push_back(*std::move(channel));
    return success();
}

/// Returns the position of '=' in NAME=SETTING.
Result<std::size_t> equals_in(const std::string& text, const SourceLocation& where, const char* example) {
    const std::size_t equals = text.find('=');
    if (equals != std::string::npos && equals > 0 && equals + 1 < text.size()) return equals;
    return error_at(where, "'" + text + "' is not a setting of a channel; expected one such as " + example);
}

Status add_rule(Job& job, const std::string& text, const SourceLocation& where) {
    const auto equals = equals_in(text, where, "Nn=zmin");
    if (!equals) return equals.error();
    auto rule = display::parse_rule_request(text.substr(0, *equals), text.substr(*equals + 1), where);
    if (!rule) return rule.error();
    job.settings.channels.rules.push_back(std::move(*rule));
    return success();
}

Status add_layer(Job& job, const std::string& text, const SourceLocation& where) {
    const auto equals = equals_in(text, where, "nearest=z:zmin");
    if (!equals) return equals.error();
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon < *equals)
        return error_at(where, "'" + text + "' has no rule; expected NAME=CHANNEL:RULE, such as nearest=z:zmin");
    auto layer = read_layer_request(text.substr(0, *equals), text.substr(*equals + 1, colon - *equals - 1),
                                    text.substr(colon + 1), where);
    if (!layer) return layer.error();
    job.settings.channels.layers.push_back(std::move(*layer));
    return success();
}

Status add_statistics(Job& job, const std::string& text, const SourceLocation& where) {
    const auto equals = equals_in(text, where, "beauty=variance,mse");
    if (!equals) return equals.error();
    for (std::size_t begin = *equals + 1; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        auto layer = display::parse_statistic_request(text.substr(0, *equals), text.substr(begin, end - begin), where);
        if (!layer) return layer.error();
        job.settings.channels.statistics.push_back(std::move(*layer));
        begin = end + 1;
    }
    return success();
}

Status set_cryptomattes(Job& job, const std::vector<RenderSetting::Item>& items) {
    job.settings.mattes.kinds.clear();
    for (const RenderSetting::Item& item : items)
        if (Status added = add_cryptomatte(item.text, item.location, job.settings.mattes); !added) return added;
    return success();
}

}  // namespace

std::vector<RenderSetting> light_layer_settings() {
    return {
        {"--lpe",
         "channel.lpe",
         "lpe",
         "NAME=EXPR",
         often,
         "adds a layer NAME with the light that the light path expression accepts",
         {.is_repeated = true}},
        {"--channels",
         "",
         "",
         "FILE",
         often,
         "adds a layer for each channel of a file, and the partitions that the file declares. The file has RIB "
         "DisplayChannel lines, rendermn.ini settings, USD ASCII RenderVar prims or TOML",
         {.is_repeated = true}},
        {"--rename",
         "",
         "",
         "OLD=NEW",
         rare,
         "gives the layer of channel OLD the name NEW, for files whose channels have the same name",
         {.is_repeated = true}},
        {"--dialect",
         "channel.dialect",
         "dialect",
         "D",
         rare,
         "syntax of the --lpe options and USD channel files after this option: renderman (default) or osl",
         {.is_repeated = true}},
        {"--partition", "channels.shipped_partition", "shipped", "shipped", rare,
         "adds the layers of the partition that comes with raylex",
         on_or_off([](Job& job) { return &job.shipped_partition; })},
        {"--light-groups", "channels.light_groups", "light_groups", "", often,
         "adds one layer per light group, and one for all lights without a group",
         on_or_off([](Job& job) { return &job.light_groups; })},
        {"", "partition", "partitions", "", rare,
         "declares that layers sum to the beauty or to another layer; proved before a ray is traced"},
        {"--techniques", "channels.techniques", "", "pyramid[:CHANNEL,...]", rare,
         "'pyramid' splits the beauty by sampling technique: a technique takes s vertices from the light and t from "
         "the camera. Each adds two layers, with its MIS weight (beauty_s1t3) and without (beauty_s1t3_unweighted). "
         "'pyramid:CHANNEL,...' splits these channels instead",
         parsed(parse_techniques, [](Job& job) { return &job.techniques; })},
        {"--no-beauty", "render.beauty", "beauty", "", rare, "renders only the light that the layers need",
         on_or_off([](Job& job) { return &job.settings.channels.beauty; })},
        {"--prune", "render.prune", "", "on|off", rare,
         "on: without beauty, light paths that no layer accepts are not simulated; off: they are simulated, to measure "
         "the saving",
         on_or_off([](Job& job) { return &job.settings.paths.prune; })},
    };
}

std::vector<RenderSetting> sample_layer_settings() {
    return {
        {"--aov", "channels.aovs", "aovs", "NAME[,NAME...]", often,
         "adds geometric AOVs by name (" + aov_names() +
             "), channels that textures of the scene write, or channels that plugins declare",
         each(add_aov, true)},
        {"--channel", "channel.type", "channels", "NAME:TYPE", rare,
         "adds a layer that plugins, patterns and materials can write by name; TYPE is float, rgb, point, normal, "
         "vector or integer",
         each(add_declared)},
        {"--rule", "channels.rules.NAME", "", "NAME=RULE", rare,
         "how samples of a channel are combined into pixels: filter (the pixel filter), zmin (nearest sample), zmax "
         "(farthest sample), min, max, average or sum",
         each(add_rule)},
        {"--layer", "layer", "", "NAME=CHANNEL:RULE", rare,
         "adds a layer with the samples of a channel, or of the beauty, combined by another rule of --rule",
         each(add_layer)},
        {"--statistics", "channels.statistics.NAME", "statistics", "NAME=STATISTIC,...", rare,
         "adds layers with statistics of the beauty or a filtered channel: NAME_variance (variance of the samples), "
         "NAME_mse (variance of the pixel), NAME_even and NAME_odd (images from samples of even and odd index)",
         each(add_statistics)},
        {"--cryptomatte", "channels.cryptomatte", "cryptomatte", "KIND[,KIND...]", often,
         "adds cryptomattes of these kinds: object, material, asset; pixel filters with negative lobes are not allowed",
         texts(set_cryptomattes, true)},
        {"--cryptomatte-ranks", "channels.cryptomatte_ranks", "", "N", rare,
         "number of ids per pixel in a cryptomatte, an even number",
         whole(
             2, geoaovs::Cryptomatte::most_ranks, [](Job& job) { return &job.settings.mattes.ranks; }, 2)},
    };
}

}  // namespace raylex::experiments
