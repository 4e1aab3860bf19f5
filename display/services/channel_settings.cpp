#include "display/services/channel_settings.h"

#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>

namespace raylex::display {
namespace {

constexpr std::array filter_rules{FilterRule::filter, FilterRule::zmin, FilterRule::zmax,   FilterRule::min,
                                  FilterRule::max,    FilterRule::sum,  FilterRule::average};
constexpr std::array types{ChannelType::real,   ChannelType::rgb,    ChannelType::point,
                           ChannelType::normal, ChannelType::vector, ChannelType::integer};
constexpr std::array statistics{Statistic::variance, Statistic::mse, Statistic::even, Statistic::odd};

/// The value with the name `text`.
template <class Value, std::size_t count>
Result<Value> named(const char* kind, const std::string& text, const std::array<Value, count>& values,
                    const char* (*name_of)(Value), const SourceLocation& where) {
    std::vector<std::string> known;
    std::string list;
    for (const Value value : values) {
        if (text == name_of(value)) return value;
        known.emplace_back(name_of(value));
        list += (list.empty() ? "" : ", ") + known.back();
    }
    return error_at(where, "unknown " + std::string(kind) + " '" + text + "'; expected one of: " + list,
                    near_miss(text, known));
}

Result<std::size_t> index_of(const std::string& name, std::span<const ChannelDefinition> channels,
                             const SourceLocation& where) {
    std::vector<std::string> known;
    std::string list;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        if (!takes_samples(channels[i])) continue;
        if (channels[i].name == name) return i;
        known.push_back(channels[i].name);
        list += (list.empty() ? "" : ", ") + known.back();
    }
    return error_at(where, "unknown channel '" + name + "'; expected one of: " + list, near_miss(name, known));
}

}  // namespace

const char* type_name(ChannelType type) {
    switch (type) {
        case ChannelType::real:
            return "float";
        case ChannelType::rgb:
            return "rgb";
        case ChannelType::point:
            return "point";
        case ChannelType::normal:
            return "normal";
        case ChannelType::vector:
            return "vector";
        case ChannelType::integer:
            return "integer";
    }
    return "";
}

Result<ChannelType> parse_channel_type(const std::string& name, const SourceLocation& where) {
    return named("channel type", name, types, type_name, where);
}

ChannelDefinition declared_channel(std::string name, ChannelType type) {
    ChannelDefinition channel;
    channel.name = std::move(name);
    channel.type = type;
    channel.declared = true;
    if (type == ChannelType::integer) channel.rule = FilterRule::zmin;
    if (type == ChannelType::rgb) channel.space = "rendering colour space";
    return channel;
}

Result<ChannelDefinition> parse_declared_channel(const std::string& text, const SourceLocation& where) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0)
        return error_at(where, "'" + text + "' is not a channel declaration; expected NAME:TYPE, such as heat:float");
    const auto type = parse_channel_type(text.substr(colon + 1), where);
    if (!type) return type.error();
    return declared_channel(text.substr(0, colon), *type);
}

Registry<ChannelDefinition>& channel_registry() {
    static Registry<ChannelDefinition> registry("channel");
    return registry;
}

const char* rule_name(FilterRule rule) {
    switch (rule) {
        case FilterRule::filter:
            return "filter";
        case FilterRule::zmin:
            return "zmin";
        case FilterRule::zmax:
            return "zmax";
        case FilterRule::min:
            return "min";
        case FilterRule::max:
            return "max";
        case FilterRule::average:
            return "average";
        case FilterRule::sum:
            return "sum";
    }
    return "";
}

const char* statistic_name(Statistic statistic) {
    switch (statistic) {
        case Statistic::none:
            return "none";
        case Statistic::variance:
            return "variance";
        case Statistic::mse:
            return "mse";
        case Statistic::even:
            return "even";
        case Statistic::odd:
            return "odd";
    }
    return "";
}

Result<RuleRequest> parse_rule_request(const std::string& channel, const std::string& rule,
                                       const SourceLocation& where) {
    const auto parsed = named("rule", rule, filter_rules, rule_name, where);
    if (!parsed) return parsed.error();
    return RuleRequest{channel, *parsed, where};
}

Result<StatisticRequest> parse_statistic_request(const std::string& channel, const std::string& statistic,
                                                 const SourceLocation& where) {
    const auto parsed = named("statistic", statistic, statistics, statistic_name, where);
    if (!parsed) return parsed.error();
    return StatisticRequest{channel, *parsed, where};
}

namespace {

Status check_rule(const ChannelDefinition& channel, FilterRule rule, const SourceLocation& where) {
    const bool mixes = rule == FilterRule::filter || rule == FilterRule::average;
    if (channel.type == ChannelType::integer && mixes)
        return error_at(where, "channel '" + channel.name +
                                   "' contains integers, whose average is meaningless; expected zmin, "
                                   "zmax, min, max or sum");
    return success();
}

}  // namespace

Status apply_rules(const std::vector<RuleRequest>& requests, ChannelId beauty,
                   std::vector<ChannelDefinition>& channels) {
    std::set<std::size_t> done;
    for (const RuleRequest& request : requests) {
        const auto index = index_of(request.channel, channels, request.location);
        if (!index) return index.error();
        ChannelDefinition& channel = channels[*index];
        if (static_cast<ChannelId>(*index) == beauty)
            return error_at(request.location,
                            "the beauty always uses the pixel filter; expected a rule for another "
                            "channel, such as one with the expression 'C.*'");
        if (!done.insert(*index).second)
            return error_at(request.location,
                            "channel '" + request.channel + "' has two rules; expected one rule for each channel");
        if (Status fits = check_rule(channel, request.rule, request.location); !fits) return fits;
        channel.rule = request.rule;
    }
    return success();
}

Status add_layers(const std::vector<LayerRequest>& requests, std::vector<ChannelDefinition>& channels) {
    for (const LayerRequest& request : requests) {
        const auto index = index_of(request.channel, channels, request.location);
        if (!index) return index.error();
        const ChannelDefinition& source = channels[*index];
        if (Status fits = check_rule(source, request.rule, request.location); !fits) return fits;
        for (const ChannelDefinition& each : channels)
            if (each.name == request.name)
                return error_at(request.location,
                                "the layer name '" + request.name + "' is taken; expected every name once");
        ChannelDefinition layer;
        layer.name = request.name;
        layer.type = source.type;
        layer.rule = request.rule;
        layer.space = source.space;
        layer.miss_value = source.miss_value;
        layer.source = static_cast<ChannelId>(*index);
        channels.push_back(std::move(layer));
    }
    return success();
}

Status add_statistics(const std::vector<StatisticRequest>& requests, std::vector<ChannelDefinition>& channels) {
    for (const StatisticRequest& request : requests) {
        const auto index = index_of(request.channel, channels, request.location);
        if (!index) return index.error();
        const ChannelDefinition& source = channels[*index];
        const std::string name = request.channel + "_" + statistic_name(request.statistic);
        if (source.rule != FilterRule::filter)
            return error_at(request.location,
                            "channel '" + request.channel + "' has the rule '" + rule_name(source.rule) +
                                "', which has no statistics; expected a channel that uses the pixel filter");
        const auto taken = std::find_if(channels.begin(), channels.end(),
                                        [&](const ChannelDefinition& each) { return each.name == name; });
        if (taken != channels.end())
            return error_at(request.location, takes_samples(*taken)
                                                  ? "the layer of statistics '" + name +
                                                        "' has the name of another "
                                                        "channel; expected that channel to have another name"
                                                  : "the layer of statistics '" + name +
                                                        "' is requested twice; expected "
                                                        "each once");
        ChannelDefinition layer;
        layer.name = name;
        layer.type = source.type;
        layer.space = source.space;
        layer.statistic = request.statistic;
        layer.source = static_cast<ChannelId>(*index);
        channels.push_back(std::move(layer));
    }
    return success();
}

}  // namespace raylex::display
