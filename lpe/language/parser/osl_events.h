// The event level of the `osl` dialect, where an event is a word of symbols: type, scatter, labels. parser_osl.cpp
// reads the words.
#pragma once

#include <string_view>
#include <vector>

#include "lpe/adopt/vocabulary.h"
#include "lpe/language/pattern.h"

namespace raylex::lpe {

/// OSL's NONE, which the unquoted letter x stands for. No quoted text is equal to it, as it is to no label: quoted
/// texts hold no quote.
inline constexpr std::string_view none_symbol = "'";

using SymbolSequence = std::vector<LabelTest>;
using SymbolSequences = std::vector<SymbolSequence>;

/// Adds alternatives, all of the single symbols among them as one test.
void add_alternatives(SymbolSequences& list, SymbolSequences more);

/// The events whose symbols are one of the sequences, each of two symbols at least; `open`: further labels may follow.
/// Names of `vocabulary`, which may be null, stand for what it says.
EventSet osl_events(const SymbolSequences& sequences, bool open, const Vocabulary* vocabulary);

}  // namespace raylex::lpe
