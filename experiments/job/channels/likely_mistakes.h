// Finds common mistakes in expressions that match no path of any scene, and suggests the correct expression.
#pragma once

#include <string>

#include "lpe/path_strings.h"
#include "lpe/program.h"

namespace raylex::experiments {

/// Returns the first common mistake whose correction matches a word in `words`: "it does not end at a light; did you
/// mean 'CDL'?". Empty if there is none.
std::string likely_mistake(const lpe::ChannelSource& channel, const lpe::PathStrings& words);

}  // namespace raylex::experiments
