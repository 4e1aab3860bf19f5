// How much of its tolerance every line of a family used, as a chart.
#pragma once

#include <span>
#include <string>

#include "experiments/stability/suite/judge_line.h"

namespace raylex::experiments {

/// SVG text: one row a case, one dot a line, from 1e-4 (and what is below) to 10 tolerances (and what is above).
/// `beside` are lines of another program, hollow.
std::string suite_chart(std::span<const LineResult> lines, std::span<const LineResult> beside);

}  // namespace raylex::experiments
