// The results of split-sum checks as text, and the heat map of a failed check.
#pragma once

#include <map>
#include <span>
#include <string>

#include "display/output/atlas/atlas_file.h"
#include "display/output/splits/split_check.h"

namespace raylex::experiments {

/// Returns the whole result of one check: the layers and their target, whether the sum holds (to rounding, within the
/// tolerance, or not), the largest errors and their pixels, the bound and its reason, the tolerance and its reasons,
/// and the pixels beyond it. `title` names the split; empty: the name of its partition.
std::string result_text(const display::SplitResult& result, const std::string& title = {});

/// Returns one line for the end of a render: "partition 'auto': 3 layers sum to beauty (largest relative error 3e-08,
/// bound 1.2e-07)".
std::string result_line(const display::SplitResult& result);

/// Lists the layers with values that the writer changed because their type cannot hold them, with counts; empty if it
/// changed none. `attributes` are those of the file's header; `remedy` is the option that stores floats.
std::string repaired_text(const std::map<std::string, std::string>& attributes,
                          const std::string& remedy = "--exr 'all=float zip'");
/// Returns the number of clamped pixels and what the file cannot show for them, `what`: "3 pixels with values clamped
/// to the largest half or float; for them the file does not show whether " + `what`.
std::string clamped_text(std::size_t pixels, const std::string& what);

/// Returns the result of an atlas check in one line: "atlas: 214 path strings, 18.3 a pixel, sum to the beauty (...)".
std::string atlas_line(const display::AtlasCheck& result, std::uint64_t pixels);
/// Checks an atlas file, prints the result and returns the exit code.
int report_atlas_check(display::AtlasFile& file);

/// Writes STEM.PARTITION.residual.png beside the image, or into the current directory if that fails, and beside it
/// STEM.PARTITION.unassigned.exr. Returns a text with the paths, or with the reason why there is none.
std::string write_residual_map(const display::SplitResult& result, const display::ExrImage& image);

/// Prints the results for a new image, one line each, and writes a residual map for each failed check. Where a check
/// holds, it removes the map that an earlier image of this name left. Returns whether all checks hold.
bool print_results_of_new(std::span<const display::SplitResult> results, const display::ExrImage& image);
/// Returns an error if `output` does not end in .exr, is one of `inputs`, or cannot be written.
Status check_new_exr(const std::string& output, std::span<const std::string> inputs = {});
/// Checks the partitions of a new file as read back from disk, prints the results and returns the exit code.
int check_new_image(const std::string& path);

}  // namespace raylex::experiments
