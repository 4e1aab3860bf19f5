#include "display/output/writer/exr_writer.h"

#include <algorithm>
#include <exception>
#include <future>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <thread>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>

#include "display/buffer/frame_buffer/banded_image.h"
#include "display/output/splits/stored_precision.h"
#include "display/output/writer/exr_header.h"
#include "display/output/writer/exr_layout.h"
#include "display/output/writer/exr_pixels.h"

namespace raylex::display {

namespace {

/// Checks the partitions against the written values while parts are written.
class WrittenSplits {
  public:
    WrittenSplits(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description)
        : frame_buffer_(frame_buffer),
          beauty_(beauty),
          cancelled_(cancelled_unit * light_magnitude_of(description.attributes)) {
        for (std::size_t i = 0; i < description.partitions.size(); ++i)
            if (is_declared(frame_buffer.channels(), beauty, description.partitions[i]))
                splits_.push_back({i, description.partitions[i], {}, {}, {}});
    }

    /// The following parts belong to these rows, until the band ends.
    void begin_band(const PixelRegion& rows) {
        for (Split& split : splits_) split.sum.emplace(rows.width(), rows.height(), cancelled_);
    }
    void end_band(const PixelRegion& rows) {
        for (Split& split : splits_) {
            SplitResult result = split.sum->result(false);
            split.sum.reset();
            if (split.result) add_rows(*split.result, result, rows.y0);
            else split.result = std::move(result);
        }
    }

    [[nodiscard]] bool wants(const PlannedPart& part) const {
        return part.data == nullptr && part.storage.type != StoredType::unsigned_int &&
               std::any_of(splits_.begin(), splits_.end(), [&](const Split& split) {
                   return name_of(part) == whole_of(split) || contains(split, name_of(part));
               });
    }
    void take(const PlannedPart& part, const PartPixels& pixels) {
        if (pixels.checked.empty()) return;
        SplitLayer layer;
        for (std::size_t c = 0; c < 3; ++c) layer.planes[c] = pixels.checked[pixels.checked.size() == 3 ? c : 0];
        layer.types.fill(part.storage.type);
        for (Split& split : splits_) {
            const bool whole = name_of(part) == whole_of(split), member = contains(split, name_of(part));
            if (whole) split.sum->add_whole(layer);
            if (member) split.sum->add(layer);
            if ((whole || member) && is_lossy(part.storage.compression)) split.lossy = storage_text(part.storage);
        }
    }
    [[nodiscard]] std::vector<SplitResult> results() const {
        std::vector<SplitResult> all;
        for (const Split& split : splits_) {
            if (!split.lossy.empty()) continue;  // the file does not contain the values that were added here
            SplitResult result = *split.result;
            result.partition = split.partition.name;
            result.of = whole_of(split);
            result.layers = split.partition.layers;
            all.push_back(std::move(result));
        }
        return all;
    }
    /// Overwrites the placeholders in the file's header. Texts have equal lengths, so nothing moves.
    void write_results(AtomicFile& file, const HeaderRecorder& header) const {
        for (const Split& split : splits_) {
            const std::size_t position = header.find(result_placeholder(split.index));
            if (position == std::string::npos) continue;
            std::string text = split.lossy.empty() ? result_attribute(*split.result, split.partition.layers.size())
                                                   : "not judged while writing: " + split.lossy +
                                                         " loses bits; raylex verify judges the file";
            text.resize(result_length, ' ');
            if (!file.seek(position) || !file.write(text.data(), text.size()))
                throw std::runtime_error("writing failed");
        }
    }

  private:
    struct Split {
        std::size_t index;
        PartitionDeclaration partition;
        std::optional<SplitSum> sum;        ///< for one band
        std::optional<SplitResult> result;  ///< for the bands that have ended
        std::string lossy;                  ///< storage of a layer that changes its values in the file; empty if
                                            ///< there is none
    };
    [[nodiscard]] std::string name_of(const PlannedPart& part) const {
        return part.channel == beauty_ ? "beauty"
                                       : frame_buffer_.channels()[static_cast<std::size_t>(part.channel)].name;
    }
    static std::string whole_of(const Split& split) {
        return split.partition.of.empty() ? "beauty" : split.partition.of;
    }
    static bool contains(const Split& split, const std::string& name) {
        const std::vector<std::string>& layers = split.partition.layers;
        return std::find(layers.begin(), layers.end(), name) != layers.end();
    }
    const PixelImage& frame_buffer_;
    ChannelId beauty_;
    double cancelled_;
    std::vector<Split> splits_;
};

/// The rows that are resolved, packed and written together. They are enough to keep the encoders busy; less data than a
/// whole image stays in the cache and in reused memory. A band is at most the image's own band, and at most two million
/// pixels, so that the pixels of a part are small compared with the image.
std::vector<PixelRegion> bands_to_write(const PixelImage& frame_buffer, const ImageDescription& description) {
    constexpr int most_pixels = 1 << 21;
    const PixelRegion all = frame_buffer.whole();
    start_encoder_threads();
    const int busy_rows = 32 * std::max(1, Imf::globalThreadCount());
    const int most_rows = std::max(1, std::min(busy_rows, most_pixels / all.x1)),
              end = description.data_window ? description.data_window->y1 : all.y1;
    std::vector<PixelRegion> bands;
    for (int y = description.data_window ? description.data_window->y0 : 0; y < end;) {
        const int next = std::min({frame_buffer.band_end(y), y + most_rows, end});
        bands.push_back({0, y, all.x1, next});
        y = next;
    }
    return bands;
}

void note_all_repairs(const PixelImage& frame_buffer, const std::vector<PixelRegion>& bands,
                      std::vector<PlannedPart>& parts) {
    std::map<PlannedPart*, Repairs> repairs;
    for (PlannedPart& part : parts)
        if (may_need_repair(frame_buffer, part)) repairs[&part];
    for (const PixelRegion& rows : bands)
        for (auto& [part, noted] : repairs) note_repairs(frame_buffer, *part, rows, noted);
    for (const auto& [part, noted] : repairs) {
        const std::string text = repairs_text(noted, part->storage.type);
        if (text.empty()) continue;
        const std::string name = "repaired/" + frame_buffer.channels()[static_cast<std::size_t>(part->channel)].name;
        part->attributes[name] = text;
        parts.front().attributes[name] = text;
    }
}

/// Adds a part's planes of these rows to the library's frame buffer. They contain whole rows, whatever the data window
/// is.
void add_slices(const PlannedPart& part, PartPixels& pixels, const PixelRegion& rows, Imf::FrameBuffer& buffer) {
    const std::size_t size = bytes_of(part.storage.type), row = size * static_cast<std::size_t>(rows.width());
    for (std::size_t p = 0; p < part.planes.size(); ++p) {
        // The library needs the address of row 0, which is outside the array; forming such a pointer is not allowed.
        const std::intptr_t origin =
            reinterpret_cast<std::intptr_t>(pixels.planes[p].data()) - static_cast<std::intptr_t>(row) * rows.y0;
        buffer.insert(part.planes[p],
                      Imf::Slice(pixel_type(part.storage.type), reinterpret_cast<char*>(origin), size, row));
    }
}

void write_part(Imf::MultiPartOutputFile& file, int index, const Imf::FrameBuffer& buffer, const PixelRegion& rows) {
    Imf::OutputPart output(file, index);
    output.setFrameBuffer(buffer);
    output.writePixels(rows.height());
}

/// One header per part, or a single one with all channels.
std::vector<Imf::Header> headers_of(const std::vector<PlannedPart>& parts, const FrameBufferLayout& layout,
                                    const ImageDescription& description) {
    std::vector<Imf::Header> headers;
    for (const PlannedPart& part : parts) headers.push_back(make_header(part, layout, description));
    if (!description.single_part) return headers;
    Imf::Header& first = headers.front();
    first.compression() = compression_of(description.storage[static_cast<std::size_t>(ChannelKind::light)].compression);
    for (const Imf::Header& other : std::span(headers).subspan(1))
        for (auto i = other.channels().begin(); i != other.channels().end(); ++i)
            first.channels().insert(i.name(), i.channel());
    headers.resize(1, first);
    return headers;
}

/// Lines that are packed faster than a thread wakes.
bool is_quick(const std::vector<PlannedPart>& parts, int width) {
    constexpr int narrow = 1024;
    return width < narrow && std::all_of(parts.begin(), parts.end(), [](const PlannedPart& part) {
               return part.storage.compression == ExrCompression::none ||
                      part.storage.compression == ExrCompression::rle;
           });
}

/// Until the file is closed the library keeps two bundles of lines for each packing thread and each part (one bundle
/// without threads), in three places.
struct EncoderThreads {
    int count = 0;
    double bytes = 0;
};

/// All threads, unless their memory would be too large.
EncoderThreads encoder_threads(const std::vector<PlannedPart>& parts, int width) {
    start_encoder_threads();
    constexpr double most_bytes = 512 << 20;
    double bundles = 0;
    for (const PlannedPart& part : parts)
        bundles += 3.0 * width * static_cast<double>(part.planes.size() * bytes_of(part.storage.type)) *
                   lines_together(part.storage.compression);
    int threads = Imf::globalThreadCount();
    while (threads > 0 && 2 * threads * bundles > most_bytes) --threads;
    return {threads, std::max(1, 2 * threads) * bundles};
}

/// Writes the parts of these rows one by one; while one part is packed, the next one is resolved.
void write_band(Imf::MultiPartOutputFile& output, const PixelImage& frame_buffer, const std::vector<PlannedPart>& parts,
                const PixelRegion& rows, bool single_part, std::launch when, WrittenSplits& splits) {
    splits.begin_band(rows);
    const auto prepare = [&](std::size_t i) {
        PartPixels pixels = part_pixels(frame_buffer, parts[i], rows, splits.wants(parts[i]));
        splits.take(parts[i], pixels);
        return pixels;
    };
    std::future<PartPixels> next = std::async(when, prepare, 0);
    std::vector<PartPixels> all;  // for a single part, whose lines contain every channel
    Imf::FrameBuffer together;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        PartPixels pixels = next.get();
        if (i + 1 < parts.size()) next = std::async(when, prepare, i + 1);
        if (single_part) {
            all.push_back(std::move(pixels));
            add_slices(parts[i], all.back(), rows, together);
            continue;
        }
        Imf::FrameBuffer buffer;
        add_slices(parts[i], pixels, rows, buffer);
        write_part(output, static_cast<int>(i), buffer, rows);
    }
    if (single_part) write_part(output, 0, together, rows);
    splits.end_band(rows);
}

void write_parts(AtomicFile& file, const PixelImage& frame_buffer, ChannelId beauty,
                 const std::vector<PlannedPart>& parts, const std::vector<PixelRegion>& bands,
                 const ImageDescription& description, std::vector<SplitResult>* results) {
    const FrameBufferLayout& layout = frame_buffer.layout();
    const std::vector<Imf::Header> headers = headers_of(parts, layout, description);
    const bool quick = is_quick(parts, layout.width);
    const int threads = quick ? 0 : encoder_threads(parts, layout.width).count;
    const auto when = quick ? std::launch::deferred : std::launch::async | std::launch::deferred;
    WrittenSplits splits(frame_buffer, beauty, description);
    HeaderRecorder stream(file);
    {
        Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()), false, threads);
        stream.stop_recording();
        for (const PixelRegion& rows : bands)
            write_band(output, frame_buffer, parts, rows, description.single_part, when, splits);
    }  // the library writes its table of chunks here
    splits.write_results(file, stream);
    if (results != nullptr) *results = splits.results();
}

}  // namespace

Status write_exr(const std::string& path, const PixelImage& frame_buffer, ChannelId beauty,
                 const ImageDescription& description, std::vector<SplitResult>* results) {
    const auto located = [&path](Error error) {
        error.file = path;
        return error;
    };
    if (Status names = check_channel_names(frame_buffer.channels(), beauty); !names)
        return located(std::move(names).error());
    Result<AtomicFile> file = AtomicFile::create(path, description.sync);
    if (!file) return std::move(file).error();
    try {
        std::vector<PlannedPart> parts = plan_parts(frame_buffer.channels(), beauty, description);
        const std::vector<PixelRegion> bands = bands_to_write(frame_buffer, description);
        note_all_repairs(frame_buffer, bands, parts);
        write_parts(*file, frame_buffer, beauty, parts, bands, description, results);
    } catch (const BandFailure& failure) { return failure.error(); } catch (const std::exception& exception) {
        if (file->failed()) return located(file->failure());
        Error error;
        error.message = std::string("cannot write the image: ") + exception.what();
        return located(error);
    }
    return file->commit();
}

std::uint64_t exr_writing_bytes(std::span<const ChannelDefinition> channels, ChannelId beauty, int width) {
    return static_cast<std::uint64_t>(encoder_threads(plan_parts(channels, beauty, {}), width).bytes);
}

}  // namespace raylex::display
