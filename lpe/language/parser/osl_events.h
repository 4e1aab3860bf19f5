// Events of the `osl` dialect. There an event is a word of symbols: type, scatter, labels. parser_osl.cpp parses the
// words.
#pragma once

#include <string_view>
#include <vector>

#include "lpe/adopt/vocabulary.h"
#include "lpe/language/pattern.h"

namespace raylex::lpe {

/// OSL's NONE, written as the unquoted letter x. It equals no quoted text and no label, because quoted texts contain no
/// quote.
inline constexpr std::string_view none_symbol = "'";

using SymbolSequence = std::vector<LabelTest>;
using SymbolSequences = std::vector<SymbolSequence>;

/// Adds alternatives; all single symbols among them become one test.
void add_alternatives(SymbolSequences& list, SymbolSequences more);

/// The events whose symbols match one of the sequences, each of at least two symbols. `open`: further labels can
/// follow. `vocabulary` defines registered names and can be null.
EventSet osl_events(const SymbolSequences& sequences, bool open, const Vocabulary* vocabulary);

}  // namespace raylex::lpe
