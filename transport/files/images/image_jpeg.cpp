// JPEG by TurboJPEG, the interface of libjpeg-turbo whose calls return errors.
#include <turbojpeg.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

struct Destroy {
    void operator()(void* decoder) const { tjDestroy(decoder); }
};

/// Four inks as three channels. Files store what is left white, so that inks multiply (Adobe's convention, which every
/// CMYK JPEG found follows).
void inks_to_rgb(std::vector<std::uint8_t>& samples) {
    std::size_t to = 0;
    for (std::size_t from = 0; from < samples.size(); from += 4)
        for (std::size_t c = 0; c < 3; ++c)
            samples[to++] = static_cast<std::uint8_t>((samples[from + c] * samples[from + 3] + 127) / 255);
    samples.resize(to);
}

}  // namespace

Result<Image> read_jpeg(const std::string& content, const std::string& path, const Encoding& encoding) {
    const std::unique_ptr<void, Destroy> decoder(tjInitDecompress());
    if (!decoder) return undecodable("libjpeg-turbo cannot start", path);
    // What a damaged file holds is a warning to the library. One that ends early, or without its end marker, is common,
    // and pbrt-v4 (by stb_image) takes what there is of it.
    const auto fatal = [&](int result) { return result != 0 && tjGetErrorCode(decoder.get()) != TJERR_WARNING; };
    const auto failure = [&] { return undecodable(std::string("JPEG: ") + tjGetErrorStr2(decoder.get()), path); };
    const auto* bytes = reinterpret_cast<const unsigned char*>(content.data());
    const auto size = static_cast<unsigned long>(content.size());
    int width = 0, height = 0, subsampling = 0, space = 0;
    const int header = tjDecompressHeader3(decoder.get(), bytes, size, &width, &height, &subsampling, &space);
    // An error after a warning has the code of the warning, but leaves no size. Nor have tables without an image.
    if (header == 0 && (width < 1 || height < 1)) return undecodable("JPEG: there is no image in the file", path);
    if (fatal(header) || width < 1 || height < 1) return failure();
    const bool grey = space == TJCS_GRAY, inks = space == TJCS_CMYK || space == TJCS_YCCK;
    const int format = grey ? TJPF_GRAY : inks ? TJPF_CMYK : TJPF_RGB;
    const auto stored_channels = static_cast<std::uint64_t>(tjPixelSize[format]);
    if (Status fits = check_unpacked_size(width, height, stored_channels, content.size(), path); !fits)
        return fits.error();
    std::vector<std::uint8_t> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                      stored_channels);
    // Scans are limited, as a small progressive file can ask for millions.
    constexpr int flags = TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT;
    // Nor does it write a row: all but a lone scan are read before the first, and errors come with their headers.
    const std::size_t row = static_cast<std::size_t>(width) * stored_channels;
    for (std::size_t i = 0; i < row; ++i) samples[i] = i % 2 == 0 ? 0 : 255;  // as no row of a JPEG is that is longer
    const std::vector<std::uint8_t> unwritten(samples.data(), samples.data() + row);
    const int result = tjDecompress2(decoder.get(), bytes, size, samples.data(), width, 0, height, format, flags);
    if (fatal(result) || (result != 0 && std::equal(unwritten.begin(), unwritten.end(), samples.begin())))
        return failure();
    std::string warning;
    if (result != 0)
        warning = std::string("JPEG: ") + tjGetErrorStr2(decoder.get()) +
                  "; expected a whole image, and what there is of it is taken, as in pbrt-v4";
    if (inks) inks_to_rgb(samples);
    Image image = from_integers(width, height, grey ? 1 : 3, std::span<const std::uint8_t>(samples), encoding);
    image.warning = std::move(warning);
    return image;
}

}  // namespace raylex::transport
