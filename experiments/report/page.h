// One self-contained HTML page: every layer of one or more images with its pixel values and shares of the light, at any
// exposure, with expressions, verdicts and provenance.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "display/output/color/color_manager.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct PageOptions {
    std::string display, view;  ///< empty: the config's defaults
    int largest_side = 0;       ///< pictures are reduced to this many pixels; 0: only to keep the page below page_bytes
};

/// About what the pixels of all images of a page may take together, unless a size is asked for.
inline constexpr std::size_t page_bytes = 48'000'000;

/// The same of the words of path atlases.
inline constexpr std::size_t words_bytes = 24'000'000;

/// The page for images written by raylex or anything else, in the order given. Pictures are embedded; nothing is
/// fetched. A NAME.json beside NAME.exr adds its statistics. An atlas behind the image of its render adds its words to
/// that; any other stands for the image that it keeps.
Result<std::string> make_page(const std::vector<std::string>& images, const display::ColorManager& color,
                              const PageOptions& options);

}  // namespace raylex::experiments
