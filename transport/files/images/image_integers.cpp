// Code that readers of integer images share: budgets, and the conversion of stored integers to linear values.
#include <limits>

#include "lpe/input/budgets.h"
#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

template <class Sample>
Image decoded(int width, int height, int channels, std::span<const Sample> samples, const Encoding& encoding) {
    constexpr std::size_t most = std::numeric_limits<Sample>::max();
    std::vector<float> table(most + 1);
    for (std::size_t i = 0; i <= most; ++i) table[i] = encoding.decode(static_cast<double>(i) / most);
    Image image{width, height, channels, std::vector<float>(samples.size())};
    // Alpha is decoded too, as in pbrt-v4: authors tune cutouts there.
    for (std::size_t i = 0; i < samples.size(); ++i) image.pixels[i] = table[samples[i]];
    return image;
}

}  // namespace

Error undecodable(const std::string& reason, const std::string& path) {
    return Error{"corrupt or unsupported image: " + (reason.empty() ? "cannot decode" : reason), path, 0, 0, {}, {}};
}

Status check_unpacked_size(int width, int height, std::uint64_t pixel_bytes, std::uint64_t file_bytes,
                           const std::string& path) {
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    const std::string shown = "the image has " + std::to_string(width) + " x " + std::to_string(height) + " pixels";
    if (pixels > budget(Budget::image_pixels)) return over_budget(Budget::image_pixels, shown, path);
    const std::uint64_t unpacked = pixels * pixel_bytes;
    if (unpacked <= budget(Budget::unpack_floor) || unpacked / budget(Budget::unpack_ratio) <= file_bytes)
        return success();
    return over_budget(Budget::unpack_ratio, shown + " in " + std::to_string(file_bytes) + " bytes", path);
}

Image from_integers(int width, int height, int channels, std::span<const std::uint8_t> samples,
                    const Encoding& encoding) {
    return decoded(width, height, channels, samples, encoding);
}

Image from_integers(int width, int height, int channels, std::span<const std::uint16_t> samples,
                    const Encoding& encoding) {
    return decoded(width, height, channels, samples, encoding);
}

}  // namespace raylex::transport
