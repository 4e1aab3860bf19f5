// One self-contained HTML page: every layer of one or more images side by side, with expressions, verdicts and
// provenance.
#pragma once

#include <string>
#include <vector>

#include "display/output/color_manager.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct PageOptions {
    std::string display, view;  ///< empty: the config's defaults
    int largest_side = 640;     ///< pictures are reduced to this many pixels
};

/// The page for images written by raylex or anything else, in the order given. Pictures are embedded; nothing is
/// fetched. A NAME.json beside NAME.exr adds its statistics.
Result<std::string> make_page(const std::vector<std::string>& images, const display::ColorManager& color,
                              const PageOptions& options);

}  // namespace raylex::experiments
