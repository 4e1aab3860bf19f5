#include "display/output/writer/exr_layout.h"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "display/output/reader/exr_layers.h"
#include "display/services/channel_settings.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

// OpenEXR allows 255 bytes for a name; the longest name derived from a channel's is "lpeDialect/NAME".
constexpr std::size_t longest_name = 255 - std::string_view("lpeDialect/").size();
constexpr std::size_t longest_shared_attribute = 1024;

std::map<std::string, std::string> channel_attributes(std::span<const ChannelDefinition> channels,
                                                      const ChannelDefinition& channel) {
    std::map<std::string, std::string> attributes{{"rule/" + channel.name, rule_name(channel.rule)}};
    if (!channel.space.empty()) attributes["space/" + channel.name] = channel.space;
    if (keeps_pixels(channel) && !takes_samples(channel))
        attributes["source/" + channel.name] = channels[static_cast<std::size_t>(channel.source)].name;
    if (!keeps_pixels(channel))
        attributes["statistics/" + channel.name] = std::string(statistic_name(channel.statistic)) + " of " +
                                                   channels[static_cast<std::size_t>(channel.source)].name;
    if (!channel.rest_of.empty()) {
        std::string text = "rest of ";
        for (std::size_t i = 0; i < channel.rest_of.size(); ++i)
            if (channel.rest_of[i] < channels.size()) text += (i == 0 ? "" : " + ") + channels[channel.rest_of[i]].name;
        if (!channel.expression.empty()) text += ": " + channel.expression;
        attributes["lpe/" + channel.name] = text;
    } else if (channel.style == ChannelStyle::expression && !channel.expression.empty()) {
        attributes["lpe/" + channel.name] = channel.expression;
        attributes["lpeDialect/" + channel.name] = channel.dialect == lpe::Dialect::osl ? "osl" : "renderman";
    }
    return attributes;
}

PlannedPart plan_part(const ChannelDefinition& channel, ChannelId id, bool beauty) {
    PlannedPart part;
    part.channel = id;
    if (beauty) {
        part.name = "rgba";
        part.alpha = true;
        part.planes = component_count(channel.type) == 3 ? std::vector<std::string>{"R", "G", "B", "A"}
                                                         : std::vector<std::string>{"Y", "A"};
        return part;
    }
    part.name = channel.name;
    if (component_count(channel.type) == 1) {
        part.planes = {channel.name == "z" ? "Z" : channel.name};  // the only spelling that compositing tools recognise
    } else {
        for (const char* suffix :
             channel.type == ChannelType::rgb ? std::array{".R", ".G", ".B"} : std::array{".X", ".Y", ".Z"})
            part.planes.push_back(channel.name + suffix);
    }
    return part;
}

Status check_name(const std::string& name) {
    if (name.empty()) return error_at({}, "a channel has no name; expected one, such as 'diffuse'");
    if (name.size() > longest_name)
        return error_at({}, "the channel name '" + name.substr(0, 40) + "...' has " + std::to_string(name.size()) +
                                " bytes; expected at most " + std::to_string(longest_name));
    if (name.find(" + ") != std::string::npos || name.find(" = ") != std::string::npos ||
        std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        return error_at({}, "the channel name '" + name +
                                "' contains \" + \", \" = \" or a control character; expected a name without them");
    return success();
}

bool has_beauty(std::span<const ChannelDefinition> channels, ChannelId beauty) {
    return beauty >= 0 && static_cast<std::size_t>(beauty) < channels.size();
}

Status check_partition(std::span<const ChannelDefinition> channels, ChannelId beauty,
                       const PartitionDeclaration& partition) {
    if (Status status = check_name(partition.name); !status) return status;
    std::set<std::string> names;
    for (std::size_t i = 0; i < channels.size(); ++i)
        if (static_cast<ChannelId>(i) != beauty) names.insert(channels[i].name);
    std::vector<std::string> known(names.begin(), names.end());
    if (has_beauty(channels, beauty)) known.push_back("beauty");
    std::vector<std::string> needed = partition.layers;
    needed.push_back(partition.of.empty() ? "beauty" : partition.of);
    for (const std::string& layer : needed)
        if (std::find(known.begin(), known.end(), layer) == known.end())
            return error_at({}, "partition '" + partition.name + "' names the layer '" + layer +
                                    "', which is not a channel; expected one of: " + list_names(known));
    return success();
}

/// Blender (3.4) stops at the first part that it cannot use, and shows every later part as black. It can use planes
/// whose last word is a single letter or one of these names, in any case. Unsigned parts are the last of all: fewer
/// programs read them.
int rank_of(const PlannedPart& part) {
    if (part.storage.type == StoredType::unsigned_int) return 2;
    const bool read = std::any_of(part.planes.begin(), part.planes.end(), [](const std::string& plane) {
        const std::string word = lower_case(std::string_view(plane).substr(plane.rfind('.') + 1));
        constexpr std::array names{"red", "green", "blue", "alpha", "depth"};
        return word.size() == 1 || std::find(names.begin(), names.end(), word) != names.end();
    });
    return read ? 0 : 1;
}

std::string interop_id(const ChannelDefinition& channel, const Chromaticities& primaries) {
    const ChannelKind kind = kind_of(channel);
    const bool color = kind == ChannelKind::light || kind == ChannelKind::color ||
                       (channel.type == ChannelType::rgb &&
                        (channel.statistic == Statistic::even || channel.statistic == Statistic::odd));
    return color ? color_interop_id(primaries) : "data";
}

}  // namespace

std::string result_placeholder(std::size_t partition) {
    std::string text = "\x01 to be judged \x01 " + std::to_string(partition) + ' ';
    text.resize(result_length, '.');
    return text;
}

bool is_declared(std::span<const ChannelDefinition> channels, ChannelId beauty, const PartitionDeclaration& partition) {
    return check_partition(channels, beauty, partition).ok();
}

Status check_channel_names(std::span<const ChannelDefinition> channels, ChannelId beauty) {
    if (channels.empty()) return error_at({}, "no channel to write; expected beauty or at least one more");
    if (channels.size() > most_layers)
        return error_at({}, "there are " + std::to_string(channels.size()) + " layers; expected at most " +
                                std::to_string(most_layers) +
                                " in a file, because each needs memory beyond its pixels");
    std::set<std::string> names;
    if (has_beauty(channels, beauty)) names = {"rgba", "beauty"};
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const std::string& name = channels[i].name;
        if (static_cast<ChannelId>(i) == beauty) continue;
        if (Status status = check_name(name); !status) return status;
        if (names.insert(name).second) continue;
        const bool taken = has_beauty(channels, beauty) && (name == "rgba" || name == "beauty");
        return error_at({}, "the channel name '" + name + "' is " + (taken ? "reserved for the beauty" : "used twice") +
                                "; expected a name of its own for every channel");
    }
    return success();
}

Status check_exr_layout(std::span<const ChannelDefinition> channels, ChannelId beauty,
                        const std::vector<PartitionDeclaration>& partitions) {
    if (Status names = check_channel_names(channels, beauty); !names) return names;
    for (const PartitionDeclaration& partition : partitions)
        if (Status status = check_partition(channels, beauty, partition); !status) return status;
    return success();
}

std::vector<PlannedPart> plan_parts(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                    const ImageDescription& description) {
    std::vector<PlannedPart> parts;
    std::map<std::string, std::string> all;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const auto id = static_cast<ChannelId>(i);
        PlannedPart part = plan_part(channels[i], id, id == beauty);
        part.storage = description.storage[static_cast<std::size_t>(kind_of(channels[i]))];
        part.attributes = channel_attributes(channels, channels[i]);
        part.attributes["storage/" + channels[i].name] = storage_text(part.storage);
        all.insert(part.attributes.begin(), part.attributes.end());
        part.attributes["colorInteropID"] = interop_id(channels[i], description.chromaticities);
        parts.insert(id == beauty ? parts.begin() : parts.end(), std::move(part));
    }
    for (const DataPart& data : description.data_parts) {
        PlannedPart part;
        part.data = &data;
        part.name = data.name;
        part.planes = data.planes;
        part.storage = description.storage[static_cast<std::size_t>(ChannelKind::value)];
        part.attributes = data.attributes;
        all.insert(data.attributes.begin(), data.attributes.end());
        part.attributes["colorInteropID"] = "data";
        parts.push_back(std::move(part));
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const PlannedPart& a, const PlannedPart& b) { return rank_of(a) < rank_of(b); });
    for (std::size_t i = 0; i < description.partitions.size(); ++i) {
        const PartitionDeclaration& partition = description.partitions[i];
        // An invalid partition must not prevent writing the image; the header contains the reason.
        const Status status = check_partition(channels, beauty, partition);
        if (status) {
            all["partition/" + partition.name] = format_partition(partition);
            all["verdict/" + partition.name] = result_placeholder(i);
        } else
            all["raylex/refusedPartition"] +=
                (all["raylex/refusedPartition"].empty() ? "" : "; ") + status.error().message;
    }
    for (PlannedPart& part : parts) {
        const bool first = &part == &parts.front();
        if (first) part.attributes.insert(all.begin(), all.end());
        for (const auto& [name, value] : description.attributes)
            if (first || value.size() <= longest_shared_attribute) part.attributes.emplace(name, value);
        if (!description.complete) part.attributes["raylex/incomplete"] = "true";
        part.attributes.emplace("software", "raylex");
    }
    return parts;
}

}  // namespace raylex::display
