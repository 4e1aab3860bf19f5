// A frame buffer in a record file, band by band: each a section of its own, so that records of images larger than
// memory are written, read and added up with no more than a band of each in memory. What a shard of a render and a cell
// of an experiment leave.
//
// Bands are of so many rows that one takes 64 MiB at most, and of one at least; records of one render have the same,
// whatever the buckets that it was rendered in.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/banded_image.h"
#include "display/checkpoint/record_file.h"

namespace raylex::display {

/// The bands of a record of this image. `raster`: with room for raster splats.
[[nodiscard]] std::vector<RowRange> record_bands(const FrameBufferLayout& layout,
                                                 std::span<const ChannelDefinition> channels, bool raster);

/// Adds the sections of an image's bands, which record_bands() counts.
Status add_bands(RecordFileWriter& writer, const FrameBuffer& buffer);
/// The same of an image in bands of its own.
Status add_bands(RecordFileWriter& writer, const std::vector<RowRange>& bands, const BandedImage& image);

/// A record file with the bands of a frame buffer.
class BandedRecord {
  public:
    /// An Error when the file has none, or not all rows of an image.
    static Result<BandedRecord> open(RecordFileReader file);

    [[nodiscard]] const RecordFileReader& file() const { return file_; }
    [[nodiscard]] const std::vector<RowRange>& bands() const { return bands_; }
    /// Of the image.
    [[nodiscard]] const FrameBufferLayout& layout() const { return layout_; }
    [[nodiscard]] const std::vector<ChannelDefinition>& channels() const { return channels_; }
    [[nodiscard]] bool raster() const { return raster_; }
    /// FrameBuffer::light_path_count() of the image.
    [[nodiscard]] std::uint64_t light_path_count() const { return light_paths_; }
    /// One of bands(). Errors name the file.
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

/// The exact sum of records in a band (FrameBuffer::merge): in any order the same bits. Memory: two bands. An Error
/// names the record that does not fit.
Result<FrameBuffer> sum_of_band(std::span<const BandedRecord> records, const RowRange& rows);
/// Of all bands, in memory; of one record, what it holds.
Result<FrameBuffer> sum_of_records(std::span<const BandedRecord> records);

}  // namespace raylex::display
