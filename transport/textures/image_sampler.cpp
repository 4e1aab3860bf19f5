#include "transport/textures/image_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raylex::transport {

namespace {

int wrap_around(int i, int n) {
    const int r = i % n;
    return r < 0 ? r + n : r;
}

/// Across an edge of an octahedral map lies the mirrored half of the same edge.
void fold_octahedral(int& along, int& across, int n_along, int n_across) {
    if (along >= 0 && along < n_along) return;
    along = along < 0 ? -1 - along : 2 * n_along - 1 - along;
    across = n_across - 1 - across;
}

/// Wraps a texel into the image; returns false outside of it (black).
bool place(const Image& image, WrapMode wrap, int& x, int& y) {
    switch (wrap) {
        case WrapMode::repeat:
            x = wrap_around(x, image.width);
            y = wrap_around(y, image.height);
            return true;
        case WrapMode::octahedral_sphere:
            fold_octahedral(x, y, image.width, image.height);
            fold_octahedral(y, x, image.height, image.width);
            [[fallthrough]];  // more than one image away
        case WrapMode::clamp:
            x = std::clamp(x, 0, image.width - 1);
            y = std::clamp(y, 0, image.height - 1);
            return true;
        case WrapMode::black:
            break;
    }
    return x >= 0 && y >= 0 && x < image.width && y < image.height;
}

/// Converts texture to pixel coordinates, in a range that is safe for integers: for `repeat`, points a period apart are
/// equal, and for the other modes all points more than an image away are equal.
Real to_pixels(Real s, int n, WrapMode wrap) {
    if (!std::isfinite(s)) s = 0;
    s = wrap == WrapMode::repeat ? s - std::floor(s) : std::clamp(s, Real(-1), Real(2));
    return s * static_cast<Real>(n) - 0.5f;
}

/// Calls `use(x, y, weight)` for up to four texels whose weights sum to 1 (less where the image ends in black).
template <class Use>
void for_texels(const ImageSampler& sampler, const Vec2& st, const Use& use) {
    const Image& image = *sampler.image;
    const Real x = to_pixels(st.x, image.width, sampler.wrap), y = to_pixels(st.y, image.height, sampler.wrap);
    if (sampler.nearest) {
        int xi = static_cast<int>(std::floor(x + 0.5f)), yi = static_cast<int>(std::floor(y + 0.5f));
        if (place(image, sampler.wrap, xi, yi)) use(xi, yi, 1.0f);
        return;
    }
    const Real x0 = std::floor(x), y0 = std::floor(y), dx = x - x0, dy = y - y0;
    const std::array<Real, 4> weight{(1 - dx) * (1 - dy), dx * (1 - dy), (1 - dx) * dy, dx * dy};
    for (int i = 0; i < 4; ++i) {
        int xi = static_cast<int>(x0) + (i & 1), yi = static_cast<int>(y0) + (i >> 1);
        if (place(image, sampler.wrap, xi, yi)) use(xi, yi, weight[static_cast<std::size_t>(i)]);
    }
}

}  // namespace

namespace {

/// The colour of a texel inside the image.
Rgb rgb_at(const Image& image, int x, int y) {
    const Real r = image.at(x, y, 0);
    return image.channels >= 3 ? Rgb(r, image.at(x, y, 1), image.at(x, y, 2)) : Rgb(r);
}
Real real_at(const ImageSampler& sampler, int x, int y) {
    const Image& image = *sampler.image;
    if (sampler.nearest) return image.at(x, y, 0);
    const bool alpha = image.channels == 4 && sampler.alpha_varies, mean = image.channels >= 3 && !alpha;
    const Real value = image.at(x, y, alpha ? 3 : 0);
    return mean ? (value + image.at(x, y, 1) + image.at(x, y, 2)) / 3 : value;
}

}  // namespace

Rgb ImageSampler::rgb(const Vec2& st) const {
    Rgb sum;
    for_texels(*this, st, [&](int x, int y, Real weight) { sum += rgb_at(*image, x, y) * weight; });
    return sum;
}

Real ImageSampler::real(const Vec2& st) const {
    Real sum = 0;
    for_texels(*this, st, [&](int x, int y, Real weight) { sum += weight * real_at(*this, x, y); });
    return sum;
}

Rgb ImageSampler::texel_rgb(int x, int y) const {
    return place(*image, wrap, x, y) ? rgb_at(*image, x, y) : Rgb();
}
Real ImageSampler::texel_real(int x, int y) const {
    return place(*image, wrap, x, y) ? image->at(x, y, 0) : 0;
}

Vec2 ImageSampler::pixel_position(const Vec2& st) const {
    return {to_pixels(st.x, image->width, wrap), to_pixels(st.y, image->height, wrap)};
}

bool alpha_varies(const Image& image) {
    if (image.channels != 4) return false;
    for (std::size_t i = 3; i < image.pixels.size(); i += 4)
        if (image.pixels[i] != 1) return true;
    return false;
}

void convert_colors(Image& image, const FileColorConversion& convert) {
    const auto channels = static_cast<std::size_t>(image.channels);
    std::vector<float> rgb(3);
    for (std::size_t i = 0; i + channels <= image.pixels.size(); i += channels) {
        const bool grey = channels < 3;
        for (std::size_t c = 0; c < 3; ++c) rgb[c] = image.pixels[i + (grey ? 0 : c)];
        convert(rgb);
        if (grey) image.pixels[i] = rgb[1];
        else
            for (std::size_t c = 0; c < 3; ++c) image.pixels[i + c] = rgb[c];
    }
}

}  // namespace raylex::transport
