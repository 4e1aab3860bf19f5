// The last step of compilation, from automata: groups, bit-parallel automata, arrays.
#pragma once

#include <span>
#include <vector>

#include "lpe/automata/groups.h"
#include "lpe/program.h"

namespace raylex::lpe {

/// Lays out groups that were made of the channels. Throws Failure when they take more words than
/// CompileOptions::word_cap.
[[nodiscard]] ProgramTables lay_out(const EventClasses& classes, const Grouping& grouping,
                                    std::span<const ChannelSource> channels, const CompileOptions& options);

/// Groups the channels first. Channel k accepts by dfas[k], minimal over `classes` and, unless
/// CompileOptions::any_word, cut to words of a renderer. Throws Failure when they fit in no way that the options allow.
[[nodiscard]] ProgramTables lay_out(const EventClasses& classes, std::vector<Dfa> dfas,
                                    std::span<const ChannelSource> channels, const CompileOptions& options);

}  // namespace raylex::lpe
