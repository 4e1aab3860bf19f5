// Writes the files of one cell or reference (listed in results.h), also from images of other programs.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/scene_store.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Writes image.exr, the arrays and record.bin of a render into an existing directory, without syncing. Returns the
/// check of the image's partitions for exactly the numbers in the file.
Result<std::vector<PartitionResult>> write_render_files(const std::string& directory, const Rendered& rendered,
                                                        const JobScene& scene,
                                                        const std::map<std::string, std::string>& attributes);

/// Writes these files from an image and the descriptions of its image and its record. `buffer` is the image, or null
/// for a sum of passes, which has no record and no moments.
Result<std::vector<PartitionResult>> write_buffer_files(const std::string& directory, const display::PixelImage& pixels,
                                                        const display::FrameBuffer* buffer, display::ChannelId beauty,
                                                        display::ImageDescription description,
                                                        display::RecordIdentity identity);
display::RecordIdentity record_identity(const Rendered& rendered);

/// Writes the arrays of an image from another program: the beauty, and the layers named like channels, without syncing.
/// Returns the channels without a layer. Errors: the image cannot be read, has no colours, has another size, a data
/// window that omits pixels, or values that are not finite.
Result<std::vector<std::string>> write_image_files(const std::string& directory, const std::string& image, int width,
                                                   int height, const std::vector<ChannelInfo>& channels);

/// Reads the frame buffer in record.bin.
Result<display::FrameBuffer> read_record(const std::string& directory);
/// Writes a record of a frame buffer in bands, without syncing; with a section `image` if its text is not empty.
Status write_sums(const std::string& path, const display::RecordIdentity& identity, const display::FrameBuffer& buffer,
                  const std::string& image = {});

/// Returns the channels of light of a render, the beauty first.
std::vector<ChannelInfo> channel_infos(const ChannelPlan& plan);

}  // namespace raylex::experiments
