#include "display/output/writer/exr_edit.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <string_view>

#include <ImfChannelList.h>
#include <ImfDeepScanLineInputPart.h>
#include <ImfDeepScanLineOutputPart.h>
#include <ImfDeepTiledInputPart.h>
#include <ImfDeepTiledOutputPart.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <half.h>

#include "display/output/reader/exr_guard.h"
#include "display/output/reader/exr_loss.h"
#include "display/output/writer/exr_header.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

/// A channel of a part that is packed again, with the values of a band of rows. Halves are converted to float;
/// `values` holds the bits of integers.
struct EditedChannel {
    ExrChannel place;
    Imf::PixelType type = Imf::FLOAT;
    bool kept = true;
    const DataPart* added = nullptr;  ///< the part that a new channel comes from
    std::size_t added_plane = 0;
    std::vector<float> values;
    std::vector<half> halves;
};

/// A part of the input, or a new one. `from` is -1 for a new one; `to` is its index in the copy, -1 if it is left out.
struct EditedPart {
    int from = 0, to = -1;
    bool packed_again = false;
    std::vector<EditedChannel> channels;  ///< empty if the part is copied without unpacking and not read
    Imf::Header header;
};

std::string part_name(const EditedPart& part) {
    return part.header.hasName() ? part.header.name() : std::to_string(part.from);
}

bool is_lossy(Imf::Compression c) {
    return c == Imf::PXR24_COMPRESSION || c == Imf::B44_COMPRESSION || c == Imf::B44A_COMPRESSION ||
           c == Imf::DWAA_COMPRESSION || c == Imf::DWAB_COMPRESSION;
}

EditedPart edited_part(const Imf::Header& header, int index, const ExrEdit& edit) {
    EditedPart part{index, -1, false, {}, header};
    if (header.hasType() && !Imf::isImage(header.type())) return part;
    bool is_read = false;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        const ExrChannel place{index, c.name()};
        const bool removed = edit.removed.count(place) > 0, changed = edit.changed.count(place) > 0;
        part.packed_again = part.packed_again || removed || changed;
        is_read = is_read || std::find(edit.planes.begin(), edit.planes.end(), place) != edit.planes.end();
        EditedChannel& channel = part.channels.emplace_back();
        channel.place = place;
        channel.type = changed && edit.changed_to_float ? Imf::FLOAT : c.channel().type;
        channel.kept = !removed;
    }
    if (!part.packed_again && !is_read) part.channels.clear();
    return part;
}

void add_channels(EditedPart& part, const DataPart& added) {
    part.packed_again = true;
    for (std::size_t plane = 0; plane < added.planes.size(); ++plane) {
        EditedChannel& channel = part.channels.emplace_back();
        channel.place = {part.from, added.planes[plane]};
        channel.added = &added;
        channel.added_plane = plane;
    }
}

/// The parts of the copy, with those that are left out.
std::vector<EditedPart> edited_parts(const Imf::MultiPartInputFile& input, const ExrEdit& edit) {
    std::vector<EditedPart> parts;
    for (int i = 0; i < input.parts(); ++i) parts.push_back(edited_part(input.header(i), i, edit));
    const Imf::Header first = input.header(0);
    for (const DataPart& added : edit.added) {
        for (const auto& [name, value] : added.attributes)
            parts.front().header.insert(name, Imf::StringAttribute(value));
        if (input.parts() == 1) {
            // All channels of a part are packed together, so unchanged channels are read too.
            if (parts.front().channels.empty()) {
                for (auto c = first.channels().begin(); c != first.channels().end(); ++c) {
                    EditedChannel& channel = parts.front().channels.emplace_back();
                    channel.place = {0, c.name()};
                    channel.type = c.channel().type;
                }
            }
            add_channels(parts.front(), added);
            continue;
        }
        EditedPart& part = parts.emplace_back();
        part.from = -1;
        part.header = Imf::Header(first.displayWindow(), first.dataWindow(), first.pixelAspectRatio());
        if (Imf::hasChromaticities(first)) Imf::addChromaticities(part.header, Imf::chromaticities(first));
        part.header.setName(added.name);
        part.header.compression() = is_lossy(first.compression()) ? Imf::ZIP_COMPRESSION : first.compression();
        for (const auto& [name, value] : added.attributes) part.header.insert(name, Imf::StringAttribute(value));
        add_channels(part, added);
    }
    return parts;
}

/// Changes the header of a part for its copy; returns false if no channel is left.
bool prepare_header(EditedPart& part, const ExrEdit& edit) {
    // Imf::Header::erase() leaks the attribute, so the header is copied without what the edit drops.
    Imf::Header left(part.header.displayWindow(), part.header.dataWindow());
    for (auto i = part.header.begin(); i != part.header.end(); ++i) {
        const bool is_text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute()) != nullptr;
        const bool is_dropped = is_text && edit.drops_attribute && edit.drops_attribute(i.name());
        if (!is_dropped && !(part.packed_again && std::string_view(i.name()) == "tiles"))
            left.insert(i.name(), i.attribute());
    }
    part.header = left;
    Imf::Header& header = part.header;
    if (!part.packed_again) {
        if (!header.hasType()) header.setType(header.hasTileDescription() ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
        return true;
    }
    header.setType(Imf::SCANLINEIMAGE);
    header.lineOrder() = Imf::INCREASING_Y;
    header.dwaCompressionLevel() = dwa_level(header);
    const Imf::ChannelList& earlier = header.channels();
    Imf::ChannelList kept;
    for (const EditedChannel& channel : part.channels) {
        if (!channel.kept) continue;
        const Imf::Channel* found = earlier.findChannel(channel.place.name);
        Imf::Channel entry = found != nullptr ? *found : Imf::Channel();
        if (edit.changed_to_float && is_lossy(header.compression())) header.compression() = Imf::ZIP_COMPRESSION;
        entry.type = channel.type;
        kept.insert(channel.place.name, entry);
    }
    header.channels() = kept;
    return kept.begin() != kept.end();
}

/// Returns an error if rows of these parts cannot be handled together.
Status check_parts(const std::string& path, const std::vector<EditedPart>& parts) {
    const EditedPart* first = nullptr;
    for (const EditedPart& part : parts) {
        if (part.channels.empty()) continue;
        if (first == nullptr) first = &part;
        if (part.header.dataWindow() != first->header.dataWindow())
            return error_at({path, 0, 0}, "the parts '" + part_name(*first) + "' and '" + part_name(part) +
                                              "' have different data windows; expected one for all layers of light");
        for (auto c = part.header.channels().begin(); c != part.header.channels().end(); ++c)
            if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
                return error_at({path, 0, 0},
                                "channel '" + std::string(c.name()) +
                                    "' has fewer values than the image has pixels; expected one for each");
    }
    return success();
}

/// The address of pixel (0, 0), which can be outside the array. Such a pointer must not be formed.
template <class Value>
Imf::Slice slice_of(Imf::PixelType type, std::vector<Value>& values, const Imath::Box2i& rows) {
    const std::int64_t width = std::int64_t{rows.max.x} - rows.min.x + 1, size = sizeof(Value);
    const std::intptr_t origin = reinterpret_cast<std::intptr_t>(values.data()) -
                                 static_cast<std::intptr_t>(size * (rows.min.x + rows.min.y * width));
    return {type, reinterpret_cast<char*>(origin), sizeof(Value), static_cast<std::size_t>(size * width)};
}

void read_rows(Imf::InputPart& input, EditedPart& part, const Imath::Box2i& rows, std::size_t pixels) {
    Imf::FrameBuffer buffer;
    for (EditedChannel& channel : part.channels) {
        if (channel.added != nullptr) continue;
        channel.values.resize(pixels);
        buffer.insert(channel.place.name,
                      slice_of(channel.type == Imf::UINT ? Imf::UINT : Imf::FLOAT, channel.values, rows));
    }
    input.setFrameBuffer(buffer);
    input.readPixels(rows.min.y, rows.max.y);
}

void write_rows(Imf::OutputPart& output, EditedPart& part, const Imath::Box2i& rows) {
    Imf::FrameBuffer buffer;
    for (EditedChannel& channel : part.channels) {
        if (!channel.kept) continue;
        if (channel.type != Imf::HALF) {
            buffer.insert(channel.place.name, slice_of(channel.type, channel.values, rows));
            continue;
        }
        channel.halves.resize(channel.values.size());
        std::transform(channel.values.begin(), channel.values.end(), channel.halves.begin(),
                       [](float value) { return half(value); });
        buffer.insert(channel.place.name, slice_of(Imf::HALF, channel.halves, rows));
    }
    output.setFrameBuffer(buffer);
    output.writePixels(rows.max.y - rows.min.y + 1);
}

/// Computes new channels for a band; they are 0 outside the display window.
void add_rows(EditedPart& part, const Imath::Box2i& rows, std::size_t pixels) {
    const Imath::Box2i& display = part.header.displayWindow();
    const Imath::Box2i inside({std::max(rows.min.x, display.min.x), std::max(rows.min.y, display.min.y)},
                              {std::min(rows.max.x, display.max.x), std::min(rows.max.y, display.max.y)});
    const auto row_length = static_cast<std::ptrdiff_t>(std::int64_t{rows.max.x} - rows.min.x + 1);
    const auto display_width = static_cast<std::ptrdiff_t>(std::int64_t{display.max.x} - display.min.x + 1);
    const DataPart* computed = nullptr;
    std::vector<float> values;
    for (EditedChannel& channel : part.channels) {
        if (channel.added == nullptr) continue;
        channel.values.assign(pixels, 0);
        if (inside.min.x > inside.max.x || inside.min.y > inside.max.y) continue;
        if (computed != channel.added) {
            values = channel.added->values(
                {0, inside.min.y - display.min.y, static_cast<int>(display_width), inside.max.y + 1 - display.min.y});
            computed = channel.added;
        }
        const std::ptrdiff_t plane = display_width * (inside.max.y + 1 - inside.min.y);
        for (int y = inside.min.y; y <= inside.max.y; ++y) {
            const auto from = values.begin() + static_cast<std::ptrdiff_t>(channel.added_plane) * plane +
                              (y - inside.min.y) * display_width + (inside.min.x - display.min.x);
            std::copy(from, from + (inside.max.x - inside.min.x + 1),
                      channel.values.begin() + (y - rows.min.y) * row_length + (inside.min.x - rows.min.x));
        }
    }
}

/// Calls `change` for a band; the planes are moved out of their channels and back.
void change_rows(std::vector<EditedPart>& parts, const Imath::Box2i& rows, const ExrEdit& edit) {
    std::vector<std::vector<float>*> places;
    std::vector<std::vector<float>> planes;
    for (const ExrChannel& place : edit.planes)
        for (EditedPart& part : parts)
            for (EditedChannel& channel : part.channels)
                if (channel.place == place) places.push_back(&channel.values);
    for (std::vector<float>* place : places) planes.push_back(std::move(*place));
    const Imath::V2i& corner = parts.front().header.displayWindow().min;
    edit.change({rows.min.x - corner.x, rows.min.y - corner.y, rows.max.x + 1 - corner.x, rows.max.y + 1 - corner.y},
                planes);
    for (std::size_t i = 0; i < places.size(); ++i) *places[i] = std::move(planes[i]);
}

void write_edited(Imf::MultiPartInputFile& input, Imf::MultiPartOutputFile& output, std::vector<EditedPart>& parts,
                  const ExrEdit& edit) {
    std::uint64_t bytes_per_pixel = 0;
    Imath::Box2i window;
    for (const EditedPart& part : parts) {
        if (!part.channels.empty()) window = part.header.dataWindow();
        bytes_per_pixel += 6 * part.channels.size();
    }
    if (bytes_per_pixel == 0) return;
    constexpr std::uint64_t band_bytes = 64 << 20;
    const auto width = static_cast<std::uint64_t>(std::int64_t{window.max.x} - window.min.x + 1);
    const auto most_rows =
        static_cast<std::int64_t>(std::max<std::uint64_t>(1, band_bytes / (bytes_per_pixel * width)));
    std::vector<std::unique_ptr<Imf::InputPart>> inputs;
    std::vector<std::unique_ptr<Imf::OutputPart>> outputs;
    for (const EditedPart& part : parts) {
        const bool written = part.packed_again && part.to >= 0;
        const bool is_read = !part.channels.empty() && part.from >= 0;
        inputs.push_back(is_read ? std::make_unique<Imf::InputPart>(input, part.from) : nullptr);
        outputs.push_back(written ? std::make_unique<Imf::OutputPart>(output, part.to) : nullptr);
    }
    for (std::int64_t y = window.min.y; y <= window.max.y; y += most_rows) {
        const Imath::Box2i rows(
            {window.min.x, static_cast<int>(y)},
            {window.max.x, static_cast<int>(std::min<std::int64_t>(y + most_rows - 1, window.max.y))});
        const std::size_t pixels = width * static_cast<std::size_t>(rows.max.y - rows.min.y + 1);
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (inputs[i]) read_rows(*inputs[i], parts[i], rows, pixels);
            add_rows(parts[i], rows, pixels);
        }
        if (edit.change) change_rows(parts, rows, edit);
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (outputs[i]) write_rows(*outputs[i], parts[i], rows);
    }
}

template <class Input, class Output>
void copy_part(Imf::MultiPartInputFile& input, Imf::MultiPartOutputFile& output, const EditedPart& part) {
    Input from(input, part.from);
    Output(output, part.to).copyPixels(from);
}

void copy_packed(Imf::MultiPartInputFile& input, Imf::MultiPartOutputFile& output, const EditedPart& part) {
    const std::string& type = part.header.type();
    if (type == Imf::SCANLINEIMAGE) copy_part<Imf::InputPart, Imf::OutputPart>(input, output, part);
    else if (type == Imf::TILEDIMAGE) copy_part<Imf::TiledInputPart, Imf::TiledOutputPart>(input, output, part);
    else if (type == Imf::DEEPTILE) copy_part<Imf::DeepTiledInputPart, Imf::DeepTiledOutputPart>(input, output, part);
    else copy_part<Imf::DeepScanLineInputPart, Imf::DeepScanLineOutputPart>(input, output, part);
}

Status edit_into(AtomicFile& file, const std::string& from, const ExrEdit& edit) {
    start_encoder_threads();
    Imf::MultiPartInputFile input(from.c_str());
    for (int i = 0; i < input.parts(); ++i)
        if (!input.partComplete(i))
            return error_at({from, 0, 0}, "the image is incomplete: part " + std::to_string(i) +
                                              " lacks pixels; expected a whole file");
    std::vector<EditedPart> parts = edited_parts(input, edit);
    std::vector<Imf::Header> headers;
    if (Status good = check_parts(from, parts); !good) return good;
    Imf::Header lost(parts.front().header.displayWindow(), parts.front().header.dataWindow());
    for (EditedPart& part : parts) {
        if (!prepare_header(part, edit)) {
            if (&part == &parts.front()) lost = part.header;
            continue;
        }
        // The first part has the attributes of the image.
        for (auto i = lost.begin(); headers.empty() && i != lost.end(); ++i)
            if (part.header.find(i.name()) == part.header.end() && std::string_view(i.name()) != "chunkCount")
                part.header.insert(i.name(), i.attribute());
        part.to = static_cast<int>(headers.size());
        if (headers.empty())
            for (const auto& [name, value] : edit.attributes) part.header.insert(name, Imf::StringAttribute(value));
        headers.push_back(part.header);
    }
    HeaderRecorder stream(file);
    Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()));
    stream.stop_recording();
    write_edited(input, output, parts, edit);
    for (const EditedPart& part : parts)
        if (part.to >= 0 && !part.packed_again) copy_packed(input, output, part);
    return success();
}

}  // namespace

Status edit_exr(const std::string& from, const std::string& to, const ExrEdit& edit) {
    if (Status sound = check_exr_file(from); !sound) return sound;
    Result<AtomicFile> file = AtomicFile::create(to);
    if (!file) return std::move(file).error();
    try {
        if (Status done = edit_into(*file, from, edit); !done) return done;
    } catch (const std::exception& exception) {
        return file->failed() ? file->failure()
                              : error_at({from, 0, 0}, std::string("cannot copy: ") + exception.what());
    }
    return file->commit();
}

}  // namespace raylex::display
