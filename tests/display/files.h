// Simulated full disks, and foreign OpenEXR files that the tests write directly with the library.
#pragma once

#include <sys/resource.h>

#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfTiledOutputFile.h>
#include <half.h>

#include "display/output/reader/exr_reader.h"
#include "tests/support/folder.h"

namespace raylex::test {

/// A disk that is full after `bytes`: the file size limit makes writes fail in the same way at the same position.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &saved_);
        rlimit limit = saved_;
        limit.rlim_cur = bytes;
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &saved_); }

  private:
    rlimit saved_{};
};

/// One channel of a foreign file: its name, stored type and pixels (row-major over the data window).
struct ForeignChannel {
    std::string name;
    Imf::PixelType type = Imf::FLOAT;
    std::vector<float> values;
};

/// Pixels converted to the stored types, kept alive while the file is written.
class ForeignPixels {
  public:
    ForeignPixels(const std::vector<ForeignChannel>& channels, const Imath::Box2i& window, Imf::Header& header) {
        const auto width = static_cast<std::size_t>(window.max.x - window.min.x + 1);
        for (const ForeignChannel& channel : channels) {
            header.channels().insert(channel.name, Imf::Channel(channel.type));
            const std::size_t size = channel.type == Imf::HALF ? 2 : 4;
            std::vector<char>& bytes = storage_.emplace_back(channel.values.size() * size);
            for (std::size_t i = 0; i < channel.values.size(); ++i) {
                if (channel.type == Imf::HALF) reinterpret_cast<half*>(bytes.data())[i] = half(channel.values[i]);
                if (channel.type == Imf::FLOAT) reinterpret_cast<float*>(bytes.data())[i] = channel.values[i];
                if (channel.type == Imf::UINT)
                    reinterpret_cast<unsigned*>(bytes.data())[i] = static_cast<unsigned>(channel.values[i]);
            }
            const auto offset =
                static_cast<std::ptrdiff_t>(window.min.x) + window.min.y * static_cast<std::ptrdiff_t>(width);
            buffer_.insert(channel.name,
                           Imf::Slice(channel.type, bytes.data() - offset * static_cast<std::ptrdiff_t>(size), size,
                                      size * width));
        }
    }
    [[nodiscard]] const Imf::FrameBuffer& buffer() const { return buffer_; }

  private:
    std::vector<std::vector<char>> storage_;
    Imf::FrameBuffer buffer_;
};

inline Imath::Box2i box(int width, int height) {
    return {Imath::V2i(0, 0), Imath::V2i(width - 1, height - 1)};
}

/// Writes a file with one part; `tile` > 0: tiled.
inline void write_foreign(const std::string& path, const std::vector<ForeignChannel>& channels,
                          const Imath::Box2i& display, const Imath::Box2i& data, int tile = 0,
                          const Imf::Chromaticities* chromaticities = nullptr) {
    Imf::Header header(display, data);
    if (chromaticities != nullptr) Imf::addChromaticities(header, *chromaticities);
    const ForeignPixels pixels(channels, data, header);
    if (tile > 0) {
        header.setTileDescription(
            Imf::TileDescription(static_cast<unsigned>(tile), static_cast<unsigned>(tile), Imf::ONE_LEVEL));
        Imf::TiledOutputFile file(path.c_str(), header);
        file.setFrameBuffer(pixels.buffer());
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
        Imf::OutputFile file(path.c_str(), header);
        file.setFrameBuffer(pixels.buffer());
        file.writePixels(data.max.y - data.min.y + 1);
    }
}

inline void write_foreign(const std::string& path, const std::vector<ForeignChannel>& channels, int width, int height) {
    write_foreign(path, channels, box(width, height), box(width, height));
}

struct ForeignPart {
    std::string name;
    std::vector<ForeignChannel> channels;
};

inline void write_foreign_parts(const std::string& path, const std::vector<ForeignPart>& parts, int width, int height) {
    std::vector<Imf::Header> headers;
    std::vector<ForeignPixels> pixels;
    for (const ForeignPart& part : parts) {
        Imf::Header header(width, height);
        header.setName(part.name);
        header.setType(Imf::SCANLINEIMAGE);
        pixels.emplace_back(part.channels, box(width, height), header);
        headers.push_back(header);
    }
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < parts.size(); ++i) {
        Imf::OutputPart part(file, static_cast<int>(i));
        part.setFrameBuffer(pixels[i].buffer());
        part.writePixels(height);
    }
}

/// An image in memory: layers of R G B, or of single planes with the name of the layer.
inline display::ImageLayer color_layer(const std::string& name, const std::vector<std::array<float, 3>>& pixels,
                                       display::StoredType type = display::StoredType::single_float) {
    display::ImageLayer layer{name, name, {{"R", type, {}}, {"G", type, {}}, {"B", type, {}}}};
    for (const auto& pixel : pixels)
        for (std::size_t c = 0; c < 3; ++c) layer.planes[c].values.push_back(pixel[c]);
    return layer;
}

inline display::ExrImage image_of(int width, int height, std::vector<display::ImageLayer> layers) {
    display::ExrImage image;
    image.path = "constructed.exr";
    image.width = width;
    image.height = height;
    image.layers = std::move(layers);
    return image;
}

}  // namespace raylex::test
