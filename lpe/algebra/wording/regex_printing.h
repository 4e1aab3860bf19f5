// From an automaton back to a text that people read, in the `renderman` dialect.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "lpe/language/extensions.h"
#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

/// Longer texts are no help to anybody and are not shown.
inline constexpr std::size_t longest_printed_expression = 160;

/// An expression for what the channels leave of `beauty` (of W when absent): every word of it that none of them
/// accepts. Nothing when no short one was found, or when they leave nothing. What is returned was read again and
/// proved: together with the channels it covers every word, and it shares none with them. What `words` rule out is used
/// where that makes the text shorter, and only there. Errors: a channel that does not parse.
Result<std::optional<std::string>> rest_expression(std::span<const ChannelSource> channels,
                                                   const std::optional<ChannelSource>& beauty = std::nullopt,
                                                   const Words& words = {}, Reader reader = Reader::raylex);

/// The same for one channel: a plain expression that accepts the same words of W.
Result<std::optional<std::string>> plain_expression(const ChannelSource& channel, const Words& words = {});

}  // namespace raylex::lpe
