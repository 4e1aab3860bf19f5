// What a user may set for a channel by its name: the rule that makes samples pixels, and layers of statistics.
#pragma once

#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "display/services/registry.h"

namespace raylex::display {

/// "float", "rgb", "point", "normal", "vector", "integer".
[[nodiscard]] const char* type_name(ChannelType type);
/// The type of that name. An Error at `where` lists the names and the near miss.
Result<ChannelType> parse_channel_type(const std::string& name, const SourceLocation& where);
/// The definition of a channel that a job or a plugin declares: filtered, or zmin where it holds integers, whose
/// average means nothing. What no sample writes is 0.
[[nodiscard]] ChannelDefinition declared_channel(std::string name, ChannelType type);
/// "NAME:TYPE" with the types above. Errors at `where`.
Result<ChannelDefinition> parse_declared_channel(const std::string& text, const SourceLocation& where);
/// The channels that plugins declare, requested by name as geometric AOVs are.
Registry<ChannelDefinition>& channel_registry();

/// "filter", "zmin", "zmax", "min", "max", "average", "sum".
[[nodiscard]] const char* rule_name(FilterRule rule);
/// "variance", "mse", "even", "odd"; "none".
[[nodiscard]] const char* statistic_name(Statistic statistic);

/// A channel by name and what is asked of it.
struct RuleRequest {
    std::string channel;
    FilterRule rule = FilterRule::filter;
    SourceLocation location;
};
struct StatisticRequest {
    std::string channel;  ///< "beauty" or any other that the pixel filter is applied to
    Statistic statistic = Statistic::none;
    SourceLocation location;
};

/// A further output of a channel: its samples once more, made pixels by another rule.
struct LayerRequest {
    std::string name;     ///< of the new layer
    std::string channel;  ///< "beauty" or any other that takes samples
    FilterRule rule = FilterRule::filter;
    SourceLocation location;
};

/// By the names above. Errors at `where` list what there is and the near miss.
Result<RuleRequest> parse_rule_request(const std::string& channel, const std::string& rule,
                                       const SourceLocation& where);
Result<StatisticRequest> parse_statistic_request(const std::string& channel, const std::string& statistic,
                                                 const SourceLocation& where);

/// Gives channels other rules. Errors: no such channel (with the near miss), the beauty, an average of integers, one
/// channel twice.
Status apply_rules(const std::vector<RuleRequest>& requests, ChannelId beauty,
                   std::vector<ChannelDefinition>& channels);

/// Adds a layer for each request at the end of `channels`. Errors: no such channel (with the near miss), a name that is
/// taken, an average of integers.
Status add_layers(const std::vector<LayerRequest>& requests, std::vector<ChannelDefinition>& channels);

/// Adds a layer NAME_STATISTIC for each request at the end of `channels`. Errors: no such channel (with the near miss),
/// one that is no filtered mean, a layer asked for twice or whose name is taken.
Status add_statistics(const std::vector<StatisticRequest>& requests, std::vector<ChannelDefinition>& channels);

}  // namespace raylex::display
