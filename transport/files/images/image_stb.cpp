// The one file that compiles stb_image, with its compiler warnings disabled.
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#endif
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_TGA
#define STBI_ONLY_HDR
#define STBI_ONLY_BMP
#include <stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <cstdlib>
#include <limits>
#include <memory>

#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

struct StbFree {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

/// stb_image reads zeros after the end of a file, so it decodes a truncated TGA without an error. Checks that its
/// packets cover all pixels.
bool tga_is_whole(const std::string& content) {
    constexpr std::size_t header = 18;
    if (content.size() < header) return false;
    const auto byte = [&content](std::size_t i) {
        return static_cast<std::size_t>(static_cast<unsigned char>(content[i]));
    };
    const std::size_t pixel = (byte(16) + 7) / 8, pixels = (byte(12) | byte(13) << 8) * (byte(14) | byte(15) << 8);
    std::size_t at = header + byte(0) + (byte(1) != 0 ? (byte(5) | byte(6) << 8) * ((byte(7) + 7) / 8) : 0);
    const bool run_length = byte(2) >= 8;
    if (!run_length) return content.size() >= at + pixels * pixel;
    for (std::size_t done = 0; done < pixels;) {
        if (at >= content.size()) return false;
        const std::size_t packet = byte(at), count = (packet & 127) + 1;
        at += 1 + pixel * (packet >= 128 ? 1 : count);
        done += count;
    }
    return at <= content.size();
}

/// Checks that the rows of a BMP, padded to four bytes each, are in the file. stb_image refuses compressed ones.
bool bmp_is_whole(const std::string& content) {
    constexpr std::size_t old_header = 26, header = 54;
    const auto number = [&content](std::size_t i, std::size_t bytes) {
        std::uint64_t value = 0;
        for (std::size_t k = bytes; k-- > 0;) value = value << 8 | static_cast<unsigned char>(content[i + k]);
        return value;
    };
    if (content.size() < old_header) return false;
    const bool old = number(14, 4) == 12;  // OS/2 1.x
    if (!old && content.size() < header) return false;
    const auto side = [](std::uint64_t written) {  // a negative height means rows from the top down
        return static_cast<std::uint64_t>(std::abs(std::int64_t{static_cast<std::int32_t>(written)}));
    };
    const std::uint64_t width = old ? number(18, 2) : side(number(18, 4)),
                        height = old ? number(20, 2) : side(number(22, 4)), bits = number(old ? 24 : 28, 2),
                        begin = number(10, 4);
    const std::uint64_t row = (width * bits + 31) / 32 * 4;
    return row > 0 && content.size() >= begin && (content.size() - begin) / row >= height;
}

/// Checks the runs of an HDR file. stb_image accepts a run of no pixels, and reads zeros after the end as such runs, so
/// it would never return. Scanlines of runs begin with 2 2 and their width; other scanlines, and all after them, are
/// plain pixels.
bool hdr_is_whole(const std::string& content, int width, int height) {
    const std::size_t blank = content.find("\n\n");
    const std::size_t resolution = blank == std::string::npos ? blank : content.find('\n', blank + 2);
    if (resolution == std::string::npos) return false;
    std::size_t at = resolution + 1;
    const auto byte = [&content](std::size_t i) {
        return i < content.size() ? static_cast<int>(static_cast<unsigned char>(content[i])) : 0;
    };
    const auto plain = [&](int rows) {
        const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(rows);
        return content.size() >= at && (content.size() - at) / 4 >= pixels;
    };
    if (width < 8 || width >= 32'768) return plain(height);
    for (int row = 0; row < height; ++row) {
        if (byte(at) != 2 || byte(at + 1) != 2 || (byte(at + 2) & 0x80) != 0) return row == 0 && plain(height);
        at += 4;
        for (int left = 4 * width; left > 0;) {
            const int mark = byte(at), count = mark > 128 ? mark - 128 : mark;
            if (count == 0 || count > (left - 1) % width + 1) return false;
            at += mark > 128 ? 2 : 1 + static_cast<std::size_t>(count);
            if (at > content.size()) return false;
            left -= count;
        }
    }
    return true;
}

}  // namespace

Result<Image> read_with_stb(const std::string& content, const std::string& path, const Encoding& encoding) {
    const auto failure = [&path](const char* reason) { return undecodable(reason != nullptr ? reason : "", path); };
    if (content.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return failure("larger than 2 GiB");
    const bool hdr = content.starts_with("#?"), bmp = content.starts_with("BM");
    if (bmp && !bmp_is_whole(content)) return failure("BMP is truncated; expected as many rows as its header states");
    if (!hdr && !bmp && !tga_is_whole(content))
        return failure("TGA is truncated; expected as many pixels as its header states");
    const auto* bytes = reinterpret_cast<const stbi_uc*>(content.data());
    const int size = static_cast<int>(content.size());
    int width = 0, height = 0, channels = 0;
    if (stbi_info_from_memory(bytes, size, &width, &height, &channels) == 0) return failure(stbi_failure_reason());
    height = std::abs(height);  // BMP from the top down: the height is negative
    const std::uint64_t pixel_bytes = static_cast<std::uint64_t>(channels) * (hdr ? sizeof(float) : 1);
    if (Status fits = check_unpacked_size(width, height, pixel_bytes, content.size(), path); !fits) return fits.error();
    if (hdr && !hdr_is_whole(content, width, height))
        return failure("HDR is truncated or damaged; expected runs that fill each line");
    const auto samples = [&] {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels);
    };
    if (hdr) {
        const std::unique_ptr<float, StbFree> pixels(
            stbi_loadf_from_memory(bytes, size, &width, &height, &channels, 0));
        if (!pixels) return failure(stbi_failure_reason());
        return Image{width, height, channels, std::vector<float>(pixels.get(), pixels.get() + samples())};
    }
    const std::unique_ptr<stbi_uc, StbFree> pixels(stbi_load_from_memory(bytes, size, &width, &height, &channels, 0));
    if (!pixels) return failure(stbi_failure_reason());
    return from_integers(width, height, channels, std::span<const std::uint8_t>(pixels.get(), samples()), encoding);
}

}  // namespace raylex::transport
