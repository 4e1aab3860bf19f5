// Readers behind read_image, one per library. Each fills a top-down, interleaved, linear image.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "transport/files/images/image.h"

namespace raylex::transport {

/// The conversion of stored integers to linear values.
struct Encoding {
    enum class Kind : std::uint8_t { srgb, linear, gamma };
    Kind kind = Kind::srgb;
    double exponent = 1;  ///< for gamma: linear = stored ^ exponent

    [[nodiscard]] float decode(double stored) const;
};

/// Parses "", "sRGB", "linear" or "gamma <exponent>".
Result<Encoding> parse_encoding(const std::string& text);

// For each reader below, `content` is the whole file; alpha is decoded like colours, as in pbrt-v4.

/// Reads PNG by libpng: 1, 2, 4, 8 or 16 bits, with or without interlacing; palettes and transparent colours are
/// expanded.
Result<Image> read_png(const std::string& content, const std::string& path, const Encoding& encoding);
/// Reads JPEG by TurboJPEG: baseline and progressive, grey, colour and CMYK.
Result<Image> read_jpeg(const std::string& content, const std::string& path, const Encoding& encoding);
/// Reads QOI: 8 bits, with or without alpha. Without an encoding, the file specifies sRGB or linear.
Result<Image> read_qoi(const std::string& content, const std::string& path, const std::optional<Encoding>& encoding);
/// Reads TGA, HDR and BMP by stb_image.
Result<Image> read_with_stb(const std::string& content, const std::string& path, const Encoding& encoding);
/// Reads OpenEXR with R, G, B with or without A, with Y, or with one channel of any name; any pixel type; the data
/// window is kept.
Result<Image> read_exr_image(const std::string& path);
/// Reads a portable float map, "PF" (RGB) or "Pf" (grey), of either byte order; rows are stored from the bottom up. A
/// scale whose magnitude is not 1 multiplies the values.
Result<Image> read_pfm(const std::string& content, const std::string& path);

// Helpers of several readers.

[[nodiscard]] Error undecodable(const std::string& reason, const std::string& path);
/// Checks the size in the header against the budgets before anything is unpacked: a small file can contain gigabytes of
/// one colour. `pixel_bytes` is the size of an unpacked pixel.
Status check_unpacked_size(int width, int height, std::uint64_t pixel_bytes, std::uint64_t file_bytes,
                           const std::string& path);
/// Converts interleaved samples of 8 or 16 bits to linear values. The last of two or four channels is alpha.
Image from_integers(int width, int height, int channels, std::span<const std::uint8_t> samples,
                    const Encoding& encoding);
Image from_integers(int width, int height, int channels, std::span<const std::uint16_t> samples,
                    const Encoding& encoding);

}  // namespace raylex::transport
