// Split-sum verdicts as text, and the heat map that a failure leaves.
#pragma once

#include <map>
#include <span>
#include <string>

#include "display/output/atlas/atlas_file.h"
#include "display/output/splits/split_check.h"

namespace raylex::experiments {

/// What was summed and whether it holds (to rounding, as allowed, or not), the largest errors with their pixels, the
/// bound and where it comes from, what was allowed and for what, pixels past it. `title` names the split; empty: its
/// partition.
std::string verdict_text(const display::SplitVerdict& verdict, const std::string& title = {});

/// One line for the end of a render: "partition 'auto': 3 layers sum to beauty (largest relative error 3e-08,
/// bound 1.2e-07)".
std::string verdict_line(const display::SplitVerdict& verdict);

/// The layers of which the writer changed values that their type cannot hold, and how many; empty where it changed
/// none. By a header's attributes; `remedy` is the option that stores floats.
std::string repaired_text(const std::map<std::string, std::string>& attributes,
                          const std::string& remedy = "--exr 'all=float zip'");
/// "3 pixels with values at the largest number of half or float: there the file does not show whether " + `what`.
std::string clamped_text(std::size_t pixels, const std::string& what);

/// "atlas: 214 words, 18.3 a pixel, sum to the beauty (...)".
std::string atlas_line(const display::AtlasVerdict& verdict, std::uint64_t pixels);
/// Prints that of a file; the exit code.
int judge_atlas(display::AtlasFile& file);

/// Writes STEM.PARTITION.residual.png beside the image, or into the current directory when that fails. The text says
/// where it is, or why there is none.
std::string write_residual_map(const display::SplitVerdict& verdict, const display::ExrImage& image);

/// Verdicts on an image that took the place of an earlier one, a line each; a failure leaves its map, and where the
/// split holds, the map that the earlier image left is of no image any more and is removed. Returns whether all hold.
bool print_verdicts_of_new(std::span<const display::SplitVerdict> verdicts, const display::ExrImage& image);

}  // namespace raylex::experiments
