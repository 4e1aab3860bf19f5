// Readers behind read_image, one per library. Each fills a top-down, interleaved, linear image.
#pragma once

#include <string>
#include <string_view>

#include "transport/import/image.h"

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

/// PNG, JPEG, TGA, HDR by stb_image. Alpha is never decoded. `content` is the whole file.
Result<Image> read_with_stb(const std::string& content, const std::string& path, const Encoding& encoding);
/// R, G, B with or without A, Y, or a file of one channel, whatever its name; any pixel type; the data window is kept.
Result<Image> read_exr_image(const std::string& path);
/// Portable float map, "PF" (RGB) or "Pf" (grey), either byte order; rows are stored from the bottom up. A scale whose
/// magnitude is not 1 multiplies.
Result<Image> read_pfm(const std::string& content, const std::string& path);

}  // namespace raylex::transport
