// Expressions that no path can match, whatever the scene: the usual slips, each told by the expression that was meant.
#pragma once

#include <string>

#include "lpe/program.h"
#include "lpe/words.h"

namespace raylex::experiments {

/// "it does not end at a light; did you mean 'CDL'?": the first of the usual slips whose correction some word of
/// `words` matches; empty when none is.
std::string likely_slip(const lpe::ChannelSource& channel, const lpe::Words& words);

}  // namespace raylex::experiments
