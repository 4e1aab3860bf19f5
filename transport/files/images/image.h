// Image files for textures and image lights: PNG, EXR, HDR, PFM, JPEG, TGA.
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
    ColorSpace space = ColorSpace::srgb;  ///< of RGB: what an OpenEXR file says; other formats do not, and are sRGB
    bool other_space = false;             ///< it says another, of which nothing is known here
    std::string warning{};                ///< what its reader did that the file may not mean; else empty

    [[nodiscard]] float at(int x, int y, int c) const {
        return pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                          static_cast<std::size_t>(channels) +
                      static_cast<std::size_t>(c)];
    }
};

/// `encoding`: "sRGB" (the default for 8-bit files), "linear", or "gamma <exponent>"; ignored for float formats.
Result<Image> read_image(const std::string& path, const std::string& encoding = {});

/// What to say where colours are used of an image that has Image::other_space.
inline constexpr const char* space_is_unknown =
    "its chromaticities are none of sRGB, DCI-P3, Rec. 2020 or ACES2065-1; taken as sRGB, as pbrt-v4 does";

/// Textures keep negative values, and their users settle what they mean: displacements may be negative.
enum class NegativeTexels : std::uint8_t { kept, cleared };
/// Takes values that are not finite as 0, before interpolation spreads them, and negative ones if asked to. Says how
/// many there were and where the first one is; nothing when there were none.
std::optional<std::string> clear_invalid_texels(Image& image, NegativeTexels negative);

}  // namespace raylex::transport
