#include "display/output/exr_writer.h"

#include <algorithm>
#include <exception>
#include <future>
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

#include "display/output/exr_header.h"
#include "display/output/exr_layout.h"
#include "display/output/exr_pixels.h"

namespace raylex::display {

namespace {

/// The verdicts of the partitions on what is being written, kept up while parts go by.
class WrittenSplits {
  public:
    WrittenSplits(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description)
        : frame_buffer_(frame_buffer), beauty_(beauty) {
        for (std::size_t i = 0; i < description.partitions.size(); ++i)
            if (is_declared(frame_buffer.channels(), beauty, description.partitions[i]))
                splits_.push_back({i, description.partitions[i],
                                   SplitSum(frame_buffer.layout().width, frame_buffer.layout().height)});
    }

    [[nodiscard]] bool wants(const PlannedPart& part) const {
        return part.data == nullptr && part.storage.type != StoredType::unsigned_int &&
               std::any_of(splits_.begin(), splits_.end(), [&](const Split& split) {
                   return name_of(part) == whole_of(split) || contains(split, name_of(part));
               });
    }
    void take(const PlannedPart& part, const PartPixels& pixels) {
        if (pixels.judged.empty()) return;
        SplitLayer layer;
        for (std::size_t c = 0; c < 3; ++c) layer.planes[c] = pixels.judged[pixels.judged.size() == 3 ? c : 0];
        layer.types.fill(part.storage.type);
        for (Split& split : splits_) {
            const bool whole = name_of(part) == whole_of(split), member = contains(split, name_of(part));
            if (whole) split.sum.add_whole(layer);
            if (member) split.sum.add(layer);
            if ((whole || member) && is_lossy(part.storage.compression)) split.lossy = storage_text(part.storage);
        }
    }
    [[nodiscard]] std::vector<SplitVerdict> verdicts() const {
        std::vector<SplitVerdict> all;
        for (const Split& split : splits_) {
            if (!split.lossy.empty()) continue;  // what is in the file is not what was added up here
            SplitVerdict verdict = split.sum.verdict(false);
            verdict.partition = split.partition.name;
            verdict.of = whole_of(split);
            verdict.layers = split.partition.layers;
            all.push_back(std::move(verdict));
        }
        return all;
    }
    /// Overwrites the placeholders in the file's header. Their lengths are equal, so nothing moves.
    void write_verdicts(AtomicFile& file, const HeaderRecorder& header) const {
        for (const Split& split : splits_) {
            const std::size_t position = header.find(verdict_placeholder(split.index));
            if (position == std::string::npos) continue;
            std::string text =
                split.lossy.empty()
                    ? verdict_attribute(split.sum.verdict(false), split.partition.layers.size())
                    : "not judged while writing: " + split.lossy + " loses bits; raylex verify judges the file";
            text.resize(verdict_length, ' ');
            if (!file.seek(position) || !file.write(text.data(), text.size()))
                throw std::runtime_error("writing failed");
        }
    }

  private:
    struct Split {
        std::size_t index;
        PartitionDeclaration partition;
        SplitSum sum;
        std::string lossy{};  ///< how a layer of it is stored that is not in the file as it is here
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
    std::vector<Split> splits_;
};

void note_repairs(const PixelImage& frame_buffer, std::vector<PlannedPart>& parts) {
    for (PlannedPart& part : parts) {
        const std::string text = part.data != nullptr ? std::string() : repairs_of(frame_buffer, part);
        if (text.empty()) continue;
        const std::string name = "repaired/" + frame_buffer.channels()[static_cast<std::size_t>(part.channel)].name;
        part.attributes[name] = text;
        parts.front().attributes[name] = text;
    }
}

/// Adds a part's planes to what the library reads from. They hold the whole image, whatever the data window is.
void add_slices(const PlannedPart& part, PartPixels& pixels, const FrameBufferLayout& layout,
                Imf::FrameBuffer& buffer) {
    const std::size_t size = part.storage.type == StoredType::half_float ? 2 : 4;
    for (std::size_t p = 0; p < part.planes.size(); ++p)
        buffer.insert(part.planes[p], Imf::Slice(pixel_type(part.storage.type), pixels.planes[p].data(), size,
                                                 size * static_cast<std::size_t>(layout.width)));
}

void write_part(Imf::MultiPartOutputFile& file, int index, const Imf::FrameBuffer& buffer) {
    Imf::OutputPart output(file, index);
    output.setFrameBuffer(buffer);
    const Imath::Box2i& window = output.header().dataWindow();
    output.writePixels(window.max.y - window.min.y + 1);
}

/// One header for each part, or one with the channels of all.
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

/// Lines that are packed sooner than a thread is woken for one of them.
bool is_quick(const std::vector<PlannedPart>& parts, int width) {
    constexpr int narrow = 1024;
    return width < narrow && std::all_of(parts.begin(), parts.end(), [](const PlannedPart& part) {
               return part.storage.compression == ExrCompression::none ||
                      part.storage.compression == ExrCompression::rle;
           });
}

void write_parts(AtomicFile& file, const PixelImage& frame_buffer, ChannelId beauty,
                 const std::vector<PlannedPart>& parts, const ImageDescription& description,
                 std::vector<SplitVerdict>* verdicts) {
    const FrameBufferLayout& layout = frame_buffer.layout();
    const std::vector<Imf::Header> headers = headers_of(parts, layout, description);
    const bool quick = is_quick(parts, layout.width);
    if (!quick) start_encoder_threads();
    const auto when = quick ? std::launch::deferred : std::launch::async;
    WrittenSplits splits(frame_buffer, beauty, description);
    HeaderRecorder stream(file);
    {
        Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()), false,
                                        quick ? 0 : Imf::globalThreadCount());
        stream.stop_recording();
        const auto prepare = [&](std::size_t i) {
            PartPixels pixels = part_pixels(frame_buffer, parts[i], splits.wants(parts[i]));
            splits.take(parts[i], pixels);
            return pixels;
        };
        std::future<PartPixels> next = std::async(when, prepare, 0);
        std::vector<PartPixels> all;  // of a single part, whose lines hold every channel
        Imf::FrameBuffer together;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            PartPixels pixels = next.get();
            if (i + 1 < parts.size()) next = std::async(when, prepare, i + 1);
            if (description.single_part) {
                all.push_back(std::move(pixels));
                add_slices(parts[i], all.back(), layout, together);
                continue;
            }
            Imf::FrameBuffer buffer;
            add_slices(parts[i], pixels, layout, buffer);
            write_part(output, static_cast<int>(i), buffer);
        }
        if (description.single_part) write_part(output, 0, together);
    }  // the library writes its table of chunks now
    splits.write_verdicts(file, stream);
    if (verdicts != nullptr) *verdicts = splits.verdicts();
}

}  // namespace

Status write_exr(const std::string& path, const PixelImage& frame_buffer, ChannelId beauty,
                 const ImageDescription& description, std::vector<SplitVerdict>* verdicts) {
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
        note_repairs(frame_buffer, parts);
        write_parts(*file, frame_buffer, beauty, parts, description, verdicts);
    } catch (const std::exception& exception) {
        if (file->failed()) return located(file->failure());
        Error error;
        error.message = std::string("cannot write the image: ") + exception.what();
        return located(error);
    }
    return file->commit();
}

}  // namespace raylex::display
