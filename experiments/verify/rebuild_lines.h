// A rebuilt beauty in the words of compositors.
#pragma once

#include <string>
#include <vector>

#include "display/output/splits/split_check.h"

namespace raylex::experiments {

/// One line for each: unassigned light, how much of it is where a colour of a product is 0, light counted twice, and
/// negative values of a layer.
std::vector<std::string> rebuild_lines(const display::SplitResult& result);

}  // namespace raylex::experiments
