// Converts automata back to readable expressions in the `renderman` dialect.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "lpe/language/extensions.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// Maximum length in bytes; a longer text does not help a reader.
inline constexpr std::size_t longest_printed_expression = 160;

/// An expression for the rest: every word of `beauty` (of W when absent) that no channel accepts. Nothing when no short
/// expression was found, or when the rest is empty. The result is parsed again and proved: together with the channels
/// it covers every word, and it shares none with them. Restrictions in `words` are used only where they make the text
/// shorter. Errors: a channel does not parse.
Result<std::optional<std::string>> rest_expression(std::span<const ChannelSource> channels,
                                                   const std::optional<ChannelSource>& beauty = std::nullopt,
                                                   const PathStrings& words = {}, Reader reader = Reader::raylex);

/// A simpler expression for one channel that accepts the same words of W; nothing when no short one was found.
Result<std::optional<std::string>> plain_expression(const ChannelSource& channel, const PathStrings& words = {});

}  // namespace raylex::lpe
