// What a guide learned, from the statistics of a render to its page.
#pragma once

#include <string>
#include <string_view>

#include "experiments/job/text/json.h"
#include "transport/paths/guide/guide_view.h"

namespace raylex::experiments {

/// What a page shows. "step", "width", "height" and "camera": as in GuideView. "probabilities": of the regions that
/// points see, those of the most points first. "points": for each point 1 + the number of its region in this list, or
/// 0, as pack_integers(). "maps": the densities of the first 4,096 regions in this list at most, about 0.2 kB each, as
/// pack_bytes(): `side` x `side` cells of the square of directions (direction_square.h). The byte of a cell is 0 or
/// 128 + 10 log2(m), where m is the cell's share of the density times the number of cells: errors are at most 3.6 %.
Json guide_view_json(const transport::GuideView& view);

/// The element of the page for an image of this size, from the text of a --stats file. Empty if the file has no view of
/// such an image.
std::string guide_view_html(const std::string& record, int width, int height);

std::string_view guide_script();  ///< guide.js

}  // namespace raylex::experiments
