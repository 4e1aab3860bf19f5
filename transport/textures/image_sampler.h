// Texture look-ups in images: bilinear and nearest, with pbrt-v4's wrap modes.
#pragma once

#include <cstdint>

#include "transport/files/images/image.h"
#include "transport/math/real.h"
#include "transport/math/vec.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

enum class WrapMode : std::uint8_t { repeat, black, clamp, octahedral_sphere };

/// Look-ups at (s, t), where t = 0 is the image's top edge. All coordinates, including NaN, are safe.
struct ImageSampler {
    const Image* image;
    WrapMode wrap;
    bool nearest;
    bool alpha_varies;  ///< there is a fourth channel that is not 1 everywhere

    [[nodiscard]] Rgb rgb(const Vec2& st) const;
    /// The value for a float texture: the only channel, the mean of three, or the alpha of four if it varies. Nearest
    /// look-ups use the first channel, as pbrt-v4's MIPMap::Texel does.
    [[nodiscard]] Real real(const Vec2& st) const;
    /// The colour of one texel, with wrapping; the first channel of float textures.
    [[nodiscard]] Rgb texel_rgb(int x, int y) const;
    [[nodiscard]] Real texel_real(int x, int y) const;
    /// The position in pixels, with integer coordinates at the centres of texels.
    [[nodiscard]] Vec2 pixel_position(const Vec2& st) const;
};

/// Whether the fourth channel of `image` differs from 1 anywhere.
bool alpha_varies(const Image& image);

/// Converts colours by the file's colour space; grey stays grey.
void convert_colors(Image& image, const FileColorConversion& convert);

}  // namespace raylex::transport
