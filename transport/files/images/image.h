// Image files for textures and image lights: PNG, JPEG, TGA, BMP, QOI, HDR, OpenEXR, PFM.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lpe/result.h"
#include "transport/color/color_context.h"

namespace raylex::transport {

/// Row-major from the top, channels interleaved (1 = grey, 2 = grey+alpha, 3 = RGB, 4 = RGBA), linear values.
struct Image {
    int width = 0, height = 0, channels = 0;
    std::vector<float> pixels;
    ColorSpace space = ColorSpace::srgb;  ///< of RGB, as an OpenEXR file specifies it; sRGB for other formats
    bool other_space = false;             ///< the file specifies a colour space that raylex does not support
    std::string warning{};                ///< set if the reader had to guess the file's meaning; else empty

    [[nodiscard]] float at(int x, int y, int c) const {
        return pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                          static_cast<std::size_t>(channels) +
                      static_cast<std::size_t>(c)];
    }
};

/// Reads an image. `encoding`: "sRGB" (the default for 8-bit files), "linear", or "gamma <exponent>"; ignored for float
/// formats.
Result<Image> read_image(const std::string& path, const std::string& encoding = {});

/// The warning where colours of an image with Image::other_space are used.
inline constexpr const char* space_is_unknown =
    "its chromaticities are none of sRGB, DCI-P3, Rec. 2020 or ACES2065-1; taken as sRGB, as pbrt-v4 does";

/// Textures keep negative values, which may be meaningful: displacements may be negative.
enum class NegativeTexels : std::uint8_t { kept, cleared };
/// Sets values that are not finite, and with NegativeTexels::cleared negative ones, to 0 before interpolation spreads
/// them. Returns a message with their number and the position of the first; nothing if there were none.
std::optional<std::string> clear_invalid_texels(Image& image, NegativeTexels negative);

}  // namespace raylex::transport
