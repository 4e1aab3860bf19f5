// One self-contained HTML page for one or more images. It shows every layer with its pixel values and its share of the
// light, at any exposure, and expressions, split checks and provenance.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "display/output/color/color_manager.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct PageOptions {
    std::string display, view;  ///< empty: the config's defaults
    int largest_side = 0;  ///< pictures are reduced to this many pixels; 0: reduced only where page_bytes demands it
};

/// Approximate limit for the pixels of all images of a page together, unless the options set a size.
inline constexpr std::size_t page_bytes = 48'000'000;

/// Approximate limit for the path strings of all atlases of a page together.
inline constexpr std::size_t path_strings_bytes = 24'000'000;

/// The page for images of any renderer, in the order given. Pictures are embedded, so the page fetches nothing. The
/// statistics of NAME.exr come from NAME.json, if that exists. An atlas that follows the image of the same render adds
/// its path strings to that image. Any other atlas gets a section for the image that it contains.
Result<std::string> make_page(const std::vector<std::string>& images, const display::ColorManager& color,
                              const PageOptions& options);

}  // namespace raylex::experiments
