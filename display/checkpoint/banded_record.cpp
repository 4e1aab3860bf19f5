#include "display/checkpoint/banded_record.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/services/parameters.h"

namespace raylex::display {
namespace {

std::string section_of(const RowRange& rows) {
    return "rows " + std::to_string(rows.first) + " to " + std::to_string(rows.end);
}

std::optional<RowRange> rows_of(const std::string& section) {
    RowRange rows;
    if (std::sscanf(section.c_str(), "rows %d to %d", &rows.first, &rows.end) != 2 || section_of(rows) != section)
        return {};
    return rows;
}

Error at_file(Error error, const std::string& path) {
    error.file = path;
    return error;
}

}  // namespace

std::vector<RowRange> record_bands(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                                   bool raster) {
    constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20;
    FrameBufferLayout row = layout;
    row.height = 1;
    const std::uint64_t rows = most_bytes / total_bytes(frame_buffer_memory(row, channels, raster));
    return bands_of({0, layout.height},
                    static_cast<int>(std::clamp<std::uint64_t>(rows, 1, static_cast<std::uint64_t>(layout.height))));
}

Status add_bands(RecordFileWriter& writer, const FrameBuffer& buffer) {
    std::string bytes;
    for (const RowRange& rows : record_bands(buffer.layout(), buffer.channels(), buffer.takes_raster_splats())) {
        bytes.clear();
        buffer.append_record(bytes, rows.first, rows.end);
        if (Status added = writer.add(section_of(rows), bytes); !added) return added;
    }
    return success();
}

Status add_bands(RecordFileWriter& writer, const std::vector<RowRange>& bands, const BandedImage& image) {
    std::string bytes;
    for (const RowRange& rows : bands) {
        bytes.clear();
        if (Status packed = image.append_record(bytes, rows); !packed) return packed;
        if (Status added = writer.add(section_of(rows), bytes); !added) return added;
    }
    return success();
}

Result<BandedRecord> BandedRecord::open(RecordFileReader file) {
    BandedRecord record(std::move(file));
    const auto error = [&](const std::string& message) { return error_at({record.file_.path(), 0, 0}, message); };
    for (const std::string& section : record.file_.sections())
        if (const std::optional<RowRange> rows = rows_of(section)) record.bands_.push_back(*rows);
    if (record.bands_.empty()) return error("the record contains no image");
    int next = 0;
    for (const RowRange& rows : record.bands_) {
        if (rows.first != next || rows.end <= rows.first) return error("the record's bands do not form an image");
        next = rows.end;
    }
    const auto first = record.read(record.bands_.front());
    if (!first) return first.error();
    record.layout_ = first->layout();
    record.layout_.height = next;
    record.channels_.assign(first->channels().begin(), first->channels().end());
    record.raster_ = first->takes_raster_splats();
    record.light_paths_ = first->light_path_count();
    return record;
}

Result<FrameBuffer> BandedRecord::read(const RowRange& rows) const {
    const auto bytes = file_.read(section_of(rows));
    if (!bytes) return bytes.error();
    auto band = FrameBuffer::from_record(*bytes);
    if (!band) return at_file(band.error(), file_.path());
    const FrameBufferLayout& layout = band->layout();
    if (layout.first_row == rows.first && layout.first_row + layout.height == rows.end) return band;
    return error_at({file_.path(), 0, 0}, "section '" + section_of(rows) + "' contains other rows");
}

Result<FrameBuffer> sum_of_band(std::span<const BandedRecord> records, const RowRange& rows) {
    std::optional<FrameBuffer> sum;
    for (const BandedRecord& record : records) {
        auto band = record.read(rows);
        if (!band) return band.error();
        if (!sum) sum = *std::move(band);
        else if (Status merged = sum->merge(*band); !merged) return at_file(merged.error(), record.file().path());
    }
    return *std::move(sum);
}

Result<FrameBuffer> sum_of_records(std::span<const BandedRecord> records) {
    const BandedRecord& first = records.front();
    std::optional<FrameBuffer> all;
    for (const RowRange& rows : first.bands()) {
        auto band = sum_of_band(records, rows);
        if (!band || first.bands().size() == 1) return band;
        if (!all) {
            auto made = band->like(first.layout());
            if (!made) return at_file(made.error(), first.file().path());
            all = *std::move(made);
        }
        if (Status placed = all->place(*band); !placed) return at_file(placed.error(), first.file().path());
    }
    return *std::move(all);
}

}  // namespace raylex::display
