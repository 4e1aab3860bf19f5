#include "display/services/channel_prefixes.h"

#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"

namespace raylex::display {

SourceLocation location_of(const ChannelDefinition& channel) {
    return {channel.origin.empty() ? "channel '" + channel.name + "'" : channel.origin, channel.origin_line,
            channel.origin_column};
}

Result<ChannelPrefixes> read_prefixes(const ChannelDefinition& channel) {
    ChannelPrefixes prefixes;
    if (channel.style != ChannelStyle::expression || !channel.rest_of.empty()) return prefixes;
    lpe::ChannelSource source;
    source.name = channel.name;
    source.expression = channel.expression;
    source.dialect = channel.dialect;
    source.origin = location_of(channel).file;
    source.origin_line = channel.origin_line;
    source.origin_column = channel.origin_column;
    const Result<std::vector<std::string>> names = lpe::expression_prefixes(source);
    if (!names) return names.error();
    for (const std::string& name : *names) {
        if (name == "unoccluded") prefixes.unoccluded = true;
        if (name == "shadows") prefixes.shadows = true;
        if (name == "nothruput") prefixes.nothruput = true;
        if (name == "holdouts") prefixes.holdouts = true;
        if (name == "overwrite") prefixes.overwrite = true;
        if (name == "noinfinitecheck") prefixes.noinfinitecheck = true;
        if (name == "noclamp") prefixes.noclamp = true;
        if (name == "unweighted") prefixes.unweighted = true;
        const std::optional<lpe::TechniquePrefix> technique = lpe::technique_prefix(name);
        if (technique && prefixes.technique && prefixes.technique != technique)
            return error_at(location_of(channel),
                            "channel '" + channel.name +
                                "' has two techniques as prefixes, and no contribution is found by "
                                "both; expected one of them");
        if (technique) prefixes.technique = technique;
    }
    if (prefixes.unoccluded && prefixes.shadows)
        return error_at(location_of(channel),
                        "channel '" + channel.name +
                            "' has the prefixes 'unoccluded;' and 'shadows;', but unoccluded light "
                            "has no shadows; expected one of them");
    if (prefixes.unweighted && prefixes.emitter_sample())
        return error_at(location_of(channel),
                        "channel '" + channel.name +
                            "' has the prefix 'unweighted;' together with 'unoccluded;', 'shadows;' or "
                            "'nothruput;', which have no MIS weight; expected one of them");
    return prefixes;
}

}  // namespace raylex::display
