// Image textures over footprints: copies of an image, each half as wide and high as the previous one (Williams 1983,
// "Pyramidal parametrics"), and the look-ups that the "filter" of an imagemap selects.
//
// The footprint is a parallelogram in texture coordinates, as wide as a pixel. "point" and "bilinear" use the level
// whose texels are about as large as its longer side; "trilinear" mixes the two nearest levels. "ewa" sums texels over
// the ellipse in the footprint with a Gaussian weight, on the level of its shorter side (Heckbert 1989, "Fundamentals
// of texture mapping and image warping", section 3.5; Greene and Heckbert 1986). Ellipses longer than "maxanisotropy"
// times their width are widened. Without a footprint the image itself is used.
#pragma once

#include <vector>

#include "transport/textures/image_sampler.h"
#include "transport/textures/texture_mapping.h"

namespace raylex::transport {

enum class TextureFilter : std::uint8_t { bilinear, point, trilinear, ewa, unfiltered };

/// Levels of half the size, a quarter and so on, to 1 x 1, without the image itself. Every texel is the mean of the
/// area that it covers, which preserves the mean of the image.
struct ImagePyramid {
    std::vector<Image> levels;

    static ImagePyramid of(const Image& image);
};

struct ImageFilter {
    const ImagePyramid* pyramid = nullptr;  ///< null: unfiltered
    TextureFilter kind = TextureFilter::unfiltered;
    Real most_anisotropic = 8;

    /// The filtered value of `sampler` at `st` over a footprint in (s, t).
    [[nodiscard]] Rgb rgb(const ImageSampler& sampler, const Vec2& st, const TexelFootprint& axes) const;
    [[nodiscard]] Real real(const ImageSampler& sampler, const Vec2& st, const TexelFootprint& axes) const;

  private:
    template <class T>
    [[nodiscard]] T look_up(const ImageSampler& sampler, const Vec2& st, TexelFootprint axes) const;
    template <class T>
    [[nodiscard]] T ellipse(const ImageSampler& sampler, const Vec2& st, TexelFootprint axes) const;
    /// The sampler of a level; 0 is the image itself.
    [[nodiscard]] ImageSampler at_level(const ImageSampler& sampler, std::size_t level) const {
        ImageSampler result = sampler;
        if (level > 0) result.image = &pyramid->levels[level - 1];
        return result;
    }
    template <class T, class LookUp>
    [[nodiscard]] T between_levels(Real level, const LookUp& look_up) const;
};

}  // namespace raylex::transport
