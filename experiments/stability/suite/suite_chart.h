// A chart of the fraction of its tolerance that every line of a family used.
#pragma once

#include <span>
#include <string>

#include "experiments/stability/suite/check_line.h"

namespace raylex::experiments {

/// Returns SVG text: one row per case, one dot per line, from 1e-4 (and less) to 10 tolerances (and more). The lines of
/// another program, `beside`, are hollow dots.
std::string suite_chart(std::span<const LineResult> lines, std::span<const LineResult> baseline);

}  // namespace raylex::experiments
