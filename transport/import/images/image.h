// Image files for textures and image lights: PNG, EXR, HDR, PFM, JPEG, TGA.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Row-major from the top, channels interleaved (1 = grey, 2 = grey+alpha, 3 = RGB, 4 = RGBA), linear values.
struct Image {
    int width = 0, height = 0, channels = 0;
    std::vector<float> pixels;
    ColorSpace space = ColorSpace::srgb;  ///< of RGB: what an OpenEXR file says; other formats do not, and are sRGB
    std::string warning{};                ///< what its reader did that the file may not mean; else empty

    [[nodiscard]] float at(int x, int y, int c) const {
        return pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                          static_cast<std::size_t>(channels) +
                      static_cast<std::size_t>(c)];
    }
};

/// `encoding`: "sRGB" (the default for 8-bit files), "linear", or "gamma <exponent>"; ignored for float formats.
Result<Image> read_image(const std::string& path, const std::string& encoding = {});

/// Takes values that are not finite as 0, before interpolation spreads them, and negative ones where the image is no
/// texture, whose users settle that themselves: displacements may be negative. Says how many there were and where the
/// first one is; nothing when there are none.
enum class NegativeTexels : std::uint8_t { kept, cleared };
std::optional<std::string> clear_invalid_texels(Image& image, NegativeTexels negative);

}  // namespace raylex::transport
