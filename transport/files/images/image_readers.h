// Readers behind read_image, one per library. Each fills a top-down, interleaved, linear image.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "transport/files/images/image.h"

namespace raylex::transport {

/// How stored integers become linear values.
struct Encoding {
    enum class Kind : std::uint8_t { srgb, linear, gamma };
    Kind kind = Kind::srgb;
    double exponent = 1;  ///< of gamma: linear = stored ^ exponent

    [[nodiscard]] float decode(double stored) const;
};

/// "" and "sRGB", "linear", "gamma <exponent>".
Result<Encoding> parse_encoding(const std::string& text);

// Of each reader below, `content` is the whole file; alpha is decoded as colours are, which is what pbrt-v4 does.

/// 1, 2, 4, 8 or 16 bits, palettes and transparent colours expanded, either interlacing, by libpng.
Result<Image> read_png(const std::string& content, const std::string& path, const Encoding& encoding);
/// Baseline and progressive, grey, colour and CMYK, by TurboJPEG.
Result<Image> read_jpeg(const std::string& content, const std::string& path, const Encoding& encoding);
/// 8 bits, with or without alpha. Without an encoding the file says whether it is sRGB or linear.
Result<Image> read_qoi(const std::string& content, const std::string& path, const std::optional<Encoding>& encoding);
/// TGA, HDR and BMP by stb_image.
Result<Image> read_with_stb(const std::string& content, const std::string& path, const Encoding& encoding);
/// R, G, B with or without A, Y, or a file of one channel, whatever its name; any pixel type; the data window is kept.
Result<Image> read_exr_image(const std::string& path);
/// Portable float map, "PF" (RGB) or "Pf" (grey), either byte order; rows are stored from the bottom up. A scale whose
/// magnitude is not 1 multiplies.
Result<Image> read_pfm(const std::string& content, const std::string& path);

// What the readers share.

[[nodiscard]] Error undecodable(const std::string& reason, const std::string& path);
/// The header's size against the budgets, before anything is unpacked: a small file can hold gigabytes of one colour.
/// `pixel_bytes`: of a pixel as it is unpacked.
Status check_unpacked_size(int width, int height, std::uint64_t pixel_bytes, std::uint64_t file_bytes,
                           const std::string& path);
/// Samples of 8 or 16 bits, interleaved, as linear values. Two and four channels end with alpha.
Image from_integers(int width, int height, int channels, std::span<const std::uint8_t> samples,
                    const Encoding& encoding);
Image from_integers(int width, int height, int channels, std::span<const std::uint16_t> samples,
                    const Encoding& encoding);

}  // namespace raylex::transport
