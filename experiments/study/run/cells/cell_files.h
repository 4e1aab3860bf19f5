// The files of one cell or reference (results.h says which), and reading images of other programs into them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/scene_store.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// image.exr, the arrays and record.bin of a render, into a directory that is there; none is synced yet. Returns what
/// the image's partitions come to, of the very numbers in the file.
Result<std::vector<PartitionVerdict>> write_render_files(const std::string& directory, const Rendered& rendered,
                                                         const JobScene& scene,
                                                         const std::map<std::string, std::string>& attributes);

/// The same of a frame buffer and what its image and its record say of themselves.
Result<std::vector<PartitionVerdict>> write_buffer_files(const std::string& directory,
                                                         const display::FrameBuffer& buffer, display::ChannelId beauty,
                                                         display::ImageDescription description,
                                                         display::RecordIdentity identity);
display::RecordIdentity record_identity(const Rendered& rendered);

/// The arrays of an image of another program: the beauty, and the layers that are called like channels; not synced.
/// Returns the channels that it has no layer for. Errors: it cannot be read, has no colours, is not of this size, has a
/// data window that leaves out pixels, or values that are not finite.
Result<std::vector<std::string>> write_image_files(const std::string& directory, const std::string& image, int width,
                                                   int height, const std::vector<ChannelInfo>& channels);

/// The frame buffer of record.bin.
Result<display::FrameBuffer> read_record(const std::string& directory);
/// A record of a frame buffer in bands, not synced yet; with a section `image` where its text is not empty.
Status write_sums(const std::string& path, const display::RecordIdentity& identity, const display::FrameBuffer& buffer,
                  const std::string& image = {});

/// The channels of light of a render, the beauty first.
std::vector<ChannelInfo> channel_infos(const ChannelPlan& plan);

}  // namespace raylex::experiments
