// Stores a frame buffer in a record file as bands, each in a section of its own. Records of images larger than memory
// are written, read and merged with one band of each in memory. Shards of a render and cells of an experiment use it.
//
// A band has as many rows as fit in 64 MiB, and at least one. All records of one render have the same bands, whatever
// its buckets were.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/banded_image.h"
#include "display/checkpoint/record_file.h"

namespace raylex::display {

/// The bands of a record of this image. `raster`: include room for raster splats.
[[nodiscard]] std::vector<RowRange> record_bands(const FrameBufferLayout& layout,
                                                 std::span<const ChannelDefinition> channels, bool raster);

/// Adds the bands of an image as sections; record_bands() gives their number.
Status add_bands(RecordFileWriter& writer, const FrameBuffer& buffer);
/// Adds the sections for an image that has other bands.
Status add_bands(RecordFileWriter& writer, const std::vector<RowRange>& bands, const BandedImage& image);

/// A record file with the bands of a frame buffer.
class BandedRecord {
  public:
    /// Opens the record. An Error if the file has no bands, or lacks rows of the image.
    static Result<BandedRecord> open(RecordFileReader file);

    [[nodiscard]] const RecordFileReader& file() const { return file_; }
    [[nodiscard]] const std::vector<RowRange>& bands() const { return bands_; }
    /// The layout of the whole image.
    [[nodiscard]] const FrameBufferLayout& layout() const { return layout_; }
    [[nodiscard]] const std::vector<ChannelDefinition>& channels() const { return channels_; }
    [[nodiscard]] bool raster() const { return raster_; }
    /// FrameBuffer::light_path_count() of the image.
    [[nodiscard]] std::uint64_t light_path_count() const { return light_paths_; }
    /// Reads one of bands(). Errors name the file.
    [[nodiscard]] Result<FrameBuffer> read(const RowRange& rows) const;

  private:
    explicit BandedRecord(RecordFileReader file) : file_(std::move(file)) {}
    RecordFileReader file_;
    std::vector<RowRange> bands_;
    FrameBufferLayout layout_;
    std::vector<ChannelDefinition> channels_;
    std::uint64_t light_paths_ = 0;
    bool raster_ = false;
};

/// The exact sum of one band over all records (FrameBuffer::merge), with the same bits in any order. Needs memory for
/// two bands. An Error names the record that does not match.
Result<FrameBuffer> sum_of_band(std::span<const BandedRecord> records, const RowRange& rows);
/// The exact sum over all bands, in memory; for a single record, its content.
Result<FrameBuffer> sum_of_records(std::span<const BandedRecord> records);

}  // namespace raylex::display
