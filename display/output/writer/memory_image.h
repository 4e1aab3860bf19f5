// A frame buffer, or a layer of one, as a reader would find it in the file, without the file.
#pragma once

#include <string>

#include "display/buffer/pixel_image.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_writer.h"

namespace raylex::display {

/// The image with only the part that holds `layer` ("" or "beauty": the beauty, or the first part when there is none).
/// Errors: no such layer, with near misses.
Result<ExrImage> image_in_memory(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description,
                                 const std::string& layer);

/// All of it, but not rounded to what the file stores: every plane is float (or an integer) and has lost nothing.
ExrImage image_in_memory(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description);

}  // namespace raylex::display
