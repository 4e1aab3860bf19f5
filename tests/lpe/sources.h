// Channels for tests in a short notation.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lpe/program.h"
#include "lpe/shipped.h"

namespace lpe_test {

using raylex::lpe::ChannelSource;
using raylex::lpe::Dialect;

/// Channels from pairs of name and expression.
inline std::vector<ChannelSource> channels_of(const std::vector<std::pair<std::string, std::string>>& list,
                                              Dialect dialect = Dialect::renderman) {
    std::vector<ChannelSource> channels;
    for (const auto& [name, expression] : list) {
        ChannelSource channel;
        channel.name = name;
        channel.expression = expression;
        channel.dialect = dialect;
        channels.push_back(channel);
    }
    return channels;
}

inline ChannelSource channel_of(const std::string& expression, Dialect dialect = Dialect::renderman) {
    return channels_of({{"channel", expression}}, dialect).front();
}

/// An expression without a name, in the renderman dialect unless it begins with "osl:".
inline ChannelSource source(const std::string& text) {
    ChannelSource channel;
    channel.expression = text.starts_with("osl:") ? text.substr(4) : text;
    channel.dialect = text.starts_with("osl:") ? Dialect::osl : Dialect::renderman;
    return channel;
}

/// The shipped partition of a dialect.
inline std::vector<ChannelSource> shipped(Dialect dialect) {
    std::vector<std::pair<std::string, std::string>> list;
    for (const raylex::lpe::NamedExpression& entry : raylex::lpe::shipped_partition(dialect))
        list.emplace_back(entry.name, entry.expression);
    return channels_of(list, dialect);
}

}  // namespace lpe_test
