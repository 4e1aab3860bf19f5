// The last step of compilation, from automata: groups, bit-parallel automata, arrays.
#pragma once

#include <span>
#include <vector>

#include "lpe/automata/groups.h"
#include "lpe/program.h"

namespace raylex::lpe {

/// Arranges groups that are already formed. Throws Failure when they need more words than CompileOptions::word_cap.
[[nodiscard]] ProgramTables lay_out(const EventClasses& classes, const Grouping& grouping,
                                    std::span<const ChannelSource> channels, const CompileOptions& options);

/// Groups the channels, then arranges them. Channel k accepts by dfas[k], minimal over `classes` and, unless
/// CompileOptions::any_path_string, restricted to words of a renderer. Throws Failure when the options permit no
/// arrangement.
[[nodiscard]] ProgramTables lay_out(const EventClasses& classes, std::vector<Dfa> dfas,
                                    std::span<const ChannelSource> channels, const CompileOptions& options);

}  // namespace raylex::lpe
