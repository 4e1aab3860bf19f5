// The words of a path atlas inside a page: what each pixel's light is made of, and any expression of it, offline.
#pragma once

#include <cstddef>
#include <string>

#include "display/output/atlas/atlas_file.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Whether the atlas is of the very render that the image is of, as far as their headers say.
bool is_atlas_of(const display::AtlasFile& atlas, const display::ExrImage& image);

/// The atlas's own image: the beauty beside its words.
Result<display::ExrImage> image_of_atlas(const std::string& path);

/// What words.js reads, as elements of a section of the page; `number` tells the atlases of a page apart. Where words
/// take more than about `bytes`, pixels are joined to blocks, whose words are means over the block: a word of the page
/// then has the light of a word of the atlas all the same. Errors: a damaged file.
Result<std::string> words_html(display::AtlasFile& atlas, std::size_t number, std::size_t bytes);

/// The names that expressions of the page may use, as JSON: what lpe::builtin_names() says.
std::string expression_names();

// Scripts, compiled in from the files of these names.
std::string_view matcher_scripts();  ///< lpe_events.js, lpe_renderman.js, lpe_osl.js, lpe_matcher.js
std::string_view words_script();     ///< words.js

}  // namespace raylex::experiments
