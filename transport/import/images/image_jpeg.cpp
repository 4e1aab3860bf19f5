// JPEG by TurboJPEG, the interface of libjpeg-turbo whose calls return errors.
#include <turbojpeg.h>

#include <memory>

#include "transport/import/images/image_readers.h"

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
    const auto failure = [&] { return undecodable(std::string("JPEG: ") + tjGetErrorStr2(decoder.get()), path); };
    const auto* bytes = reinterpret_cast<const unsigned char*>(content.data());
    const auto size = static_cast<unsigned long>(content.size());
    int width = 0, height = 0, subsampling = 0, space = 0;
    if (tjDecompressHeader3(decoder.get(), bytes, size, &width, &height, &subsampling, &space) != 0) return failure();
    const bool grey = space == TJCS_GRAY, inks = space == TJCS_CMYK || space == TJCS_YCCK;
    const int format = grey ? TJPF_GRAY : inks ? TJPF_CMYK : TJPF_RGB;
    const auto stored_channels = static_cast<std::uint64_t>(tjPixelSize[format]);
    if (Status fits = check_unpacked_size(width, height, stored_channels, content.size(), path); !fits)
        return fits.error();
    std::vector<std::uint8_t> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                      stored_channels);
    // A file that was cut short is a warning to the library, which fills the rest with grey. Scans are limited, as a
    // small progressive file can ask for millions.
    constexpr int flags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT;
    if (tjDecompress2(decoder.get(), bytes, size, samples.data(), width, 0, height, format, flags) != 0)
        return failure();
    if (inks) inks_to_rgb(samples);
    return from_integers(width, height, grey ? 1 : 3, std::span<const std::uint8_t>(samples), encoding);
}

}  // namespace raylex::transport
