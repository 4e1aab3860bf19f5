// The path strings of an atlas inside a page. They show which paths contribute to a pixel, and they answer expressions
// that a reader types, without raylex.
#pragma once

#include <cstddef>
#include <string>

#include "display/output/atlas/atlas_file.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Whether the headers of the atlas and the image describe the same render.
bool is_atlas_of(const display::AtlasFile& atlas, const display::ExrImage& image);

/// The beauty image that the atlas file contains.
Result<display::ExrImage> image_of_atlas(const std::string& path);

/// The elements of a page's section that words.js reads. `number` is the number of the atlas in the page. If path
/// strings take more than about `bytes`, the page keeps means over blocks of pixels instead of pixels; a path string
/// keeps its mean light. Errors: a damaged file.
Result<std::string> path_strings_html(display::AtlasFile& atlas, std::size_t number, std::size_t bytes);

/// lpe::builtin_names() as JSON: an object from names to expressions.
std::string expression_names();

// Scripts. The build compiles these files into the program.
std::string_view lpe_script();    ///< lpe.js
std::string_view words_script();  ///< words.js

}  // namespace raylex::experiments
