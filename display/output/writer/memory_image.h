// A frame buffer, or one of its layers, in the form in which a reader finds it in the file, but without the file.
#pragma once

#include <string>

#include "display/buffer/pixel_image.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_writer.h"

namespace raylex::display {

/// The image with only the part that contains `layer` ("" or "beauty": the beauty, or the first part if there is none).
/// Errors: no such layer, with similar names.
Result<ExrImage> image_in_memory(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description,
                                 const std::string& layer);

/// The whole image, not rounded to the stored types: every plane is float (or integer) and lossless.
ExrImage image_in_memory(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description);

}  // namespace raylex::display
