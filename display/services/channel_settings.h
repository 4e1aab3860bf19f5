// User settings of a channel by its name: the rule that combines samples to pixels, and layers of statistics.
#pragma once

#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "display/services/registry.h"

namespace raylex::display {

/// The name of a type: "float", "rgb", "point", "normal", "vector", "integer".
[[nodiscard]] const char* type_name(ChannelType type);
/// Parses the name of a type. An Error at `where` lists the names and suggests a similar one.
Result<ChannelType> parse_channel_type(const std::string& name, const SourceLocation& where);
/// The definition of a channel that a job or a plugin declares. Its rule is filter, or zmin for integers, whose average
/// is meaningless. The miss value is 0.
[[nodiscard]] ChannelDefinition declared_channel(std::string name, ChannelType type);
/// Parses "NAME:TYPE" with the types above. Errors are at `where`.
Result<ChannelDefinition> parse_declared_channel(const std::string& text, const SourceLocation& where);
/// The channels that plugins declare; users request them by name like geometric AOVs.
Registry<ChannelDefinition>& channel_registry();

/// The name of a rule: "filter", "zmin", "zmax", "min", "max", "average", "sum".
[[nodiscard]] const char* rule_name(FilterRule rule);
/// The name of a statistic: "variance", "mse", "even", "odd"; "none".
[[nodiscard]] const char* statistic_name(Statistic statistic);

/// A channel by name, and the rule for it.
struct RuleRequest {
    std::string channel;
    FilterRule rule = FilterRule::filter;
    SourceLocation location;
};
struct StatisticRequest {
    std::string channel;  ///< "beauty" or any other channel with the pixel filter
    Statistic statistic = Statistic::none;
    SourceLocation location;
};

/// A further output of a channel: the same samples, combined by another rule.
struct LayerRequest {
    std::string name;     ///< name of the new layer
    std::string channel;  ///< "beauty" or any other channel that takes samples
    FilterRule rule = FilterRule::filter;
    SourceLocation location;
};

/// Parse the request of a rule, a layer or statistics. Errors, at `where`, list the valid names and suggest a similar
/// one.
Result<RuleRequest> parse_rule_request(const std::string& channel, const std::string& rule,
                                       const SourceLocation& where);
Result<StatisticRequest> parse_statistic_request(const std::string& channel, const std::string& statistic,
                                                 const SourceLocation& where);

/// Sets the rules of channels. Errors: no such channel (with a similar name), the beauty, an average of integers, a
/// channel twice.
Status apply_rules(const std::vector<RuleRequest>& requests, ChannelId beauty,
                   std::vector<ChannelDefinition>& channels);

/// Appends a layer for each request to `channels`. Errors: no such channel (with a similar name), a name that is taken,
/// an average of integers.
Status add_layers(const std::vector<LayerRequest>& requests, std::vector<ChannelDefinition>& channels);

/// Appends a layer NAME_STATISTIC for each request to `channels`. Errors: no such channel (with a similar name), a
/// channel that is not a filtered mean, a layer that is requested twice or whose name is taken.
Status add_statistics(const std::vector<StatisticRequest>& requests, std::vector<ChannelDefinition>& channels);

}  // namespace raylex::display
