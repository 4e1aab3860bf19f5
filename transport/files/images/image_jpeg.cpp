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

/// Converts four inks to three channels. Files store the remaining white, so that inks multiply (Adobe's convention,
/// which every CMYK JPEG found follows).
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
    // The library reports damage as a warning. Files that end early, or without an end marker, are common, and pbrt-v4
    // (with stb_image) uses the part that exists.
    const auto fatal = [&](int result) { return result != 0 && tjGetErrorCode(decoder.get()) != TJERR_WARNING; };
    const auto failure = [&] { return undecodable(std::string("JPEG: ") + tjGetErrorStr2(decoder.get()), path); };
    const auto* bytes = reinterpret_cast<const unsigned char*>(content.data());
    const auto size = static_cast<unsigned long>(content.size());
    int width = 0, height = 0, subsampling = 0, space = 0;
    const int header = tjDecompressHeader3(decoder.get(), bytes, size, &width, &height, &subsampling, &space);
    // An error after a warning has the warning's code, but no size. Tables without an image have no size either.
    if (header == 0 && (width < 1 || height < 1)) return undecodable("JPEG: there is no image in the file", path);
    if (fatal(header) || width < 1 || height < 1) return failure();
    const bool grey = space == TJCS_GRAY, inks = space == TJCS_CMYK || space == TJCS_YCCK;
    const int format = grey ? TJPF_GRAY : inks ? TJPF_CMYK : TJPF_RGB;
    const auto stored_channels = static_cast<std::uint64_t>(tjPixelSize[format]);
    if (Status fits = check_unpacked_size(width, height, stored_channels, content.size(), path); !fits)
        return fits.error();
    std::vector<std::uint8_t> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                      stored_channels);
    // The number of scans is limited, since a small progressive file can contain millions.
    constexpr int flags = TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT;
    // Such an error writes no row either: all scans but a lone one are read before the first row, and errors come with
    // their headers.
    const std::size_t row = static_cast<std::size_t>(width) * stored_channels;
    // a pattern that no longer row of a JPEG has
    for (std::size_t i = 0; i < row; ++i) samples[i] = i % 2 == 0 ? 0 : 255;
    const std::vector<std::uint8_t> unwritten(samples.data(), samples.data() + row);
    const int result = tjDecompress2(decoder.get(), bytes, size, samples.data(), width, 0, height, format, flags);
    if (fatal(result) || (result != 0 && std::equal(unwritten.begin(), unwritten.end(), samples.begin())))
        return failure();
    std::string warning;
    if (result != 0)
        warning = std::string("JPEG: ") + tjGetErrorStr2(decoder.get()) +
                  "; expected a whole image. The part that exists is used, as in pbrt-v4";
    if (inks) inks_to_rgb(samples);
    Image image = from_integers(width, height, grey ? 1 : 3, std::span<const std::uint8_t>(samples), encoding);
    image.warning = std::move(warning);
    return image;
}

}  // namespace raylex::transport
