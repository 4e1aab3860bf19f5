// Texels between pixels: bilinear and nearest look-ups with pbrt-v4's wrap modes.
#pragma once

#include <cstdint>

#include "transport/files/images/image.h"
#include "transport/math/real.h"
#include "transport/math/vec.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

enum class WrapMode : std::uint8_t { repeat, black, clamp, octahedral_sphere };

/// Values at (s, t) with t = 0 at the image's top edge. Any coordinates, NaN included, are safe.
struct ImageSampler {
    const Image* image;
    WrapMode wrap;
    bool nearest;
    bool alpha_varies;  ///< a fourth channel that is not 1 everywhere

    [[nodiscard]] Rgb rgb(const Vec2& st) const;
    /// What a float texture reads: the only channel, the mean of three, or the alpha of four where it varies; of
    /// nearest texels the first channel, as pbrt-v4's MIPMap::Texel.
    [[nodiscard]] Real real(const Vec2& st) const;
    /// Of one texel, wrapped; of numbers the first channel.
    [[nodiscard]] Rgb texel_rgb(int x, int y) const;
    [[nodiscard]] Real texel_real(int x, int y) const;
    /// Texels count from their middles.
    [[nodiscard]] Vec2 pixel_position(const Vec2& st) const;
};

/// Whether the fourth channel of `image` differs from 1 anywhere.
bool alpha_varies(const Image& image);

/// Colours by what the file's colour space says; grey stays grey.
void convert_colors(Image& image, const FileColorConversion& convert);

}  // namespace raylex::transport
