#include "transport/textures/image_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "display/services/elementary.h"
#include "transport/geometry/ray.h"

namespace raylex::transport {
namespace {

Real length_of(const Vec2& v) {
    return std::sqrt(v.x * v.x + v.y * v.y);
}

/// The texels of a row that cover [first, last) of a longer row, with their weights.
struct Cover {
    int first, last;
    double left, right;  // weights of the first and last texel; those in between have weight 1

    Cover(int i, int small, int large) {
        const double begin = static_cast<double>(i) * large / small, end = static_cast<double>(i + 1) * large / small;
        first = static_cast<int>(begin);
        last = std::min(static_cast<int>(std::ceil(end)), large);
        left = std::min<double>(first + 1, end) - begin;
        right = end - std::max<double>(last - 1, begin);
    }
    [[nodiscard]] double weight(int at) const { return at == first ? left : at == last - 1 ? right : 1; }
};

Image half_of(const Image& image) {
    Image half;
    half.width = std::max(1, image.width / 2);
    half.height = std::max(1, image.height / 2);
    half.channels = image.channels;
    half.pixels.reserve(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height) *
                        static_cast<std::size_t>(half.channels));
    for (int y = 0; y < half.height; ++y) {
        const Cover rows(y, half.height, image.height);
        for (int x = 0; x < half.width; ++x) {
            const Cover columns(x, half.width, image.width);
            for (int c = 0; c < half.channels; ++c) {
                double sum = 0, weights = 0;
                for (int j = rows.first; j < rows.last; ++j)
                    for (int i = columns.first; i < columns.last; ++i) {
                        const double w = rows.weight(j) * columns.weight(i);
                        sum += w * static_cast<double>(image.at(i, j, c));
                        weights += w;
                    }
                half.pixels.push_back(static_cast<float>(sum / weights));
            }
        }
    }
    return half;
}

/// exp(-2 r^2) - exp(-2) for r^2 from 0 to 1: 0 at the ellipse's edge.
class GaussianTable {
  public:
    GaussianTable() {
        for (std::size_t i = 0; i < values_.size(); ++i)
            values_[i] = static_cast<Real>(
                elementary::exp(-2 * static_cast<double>(i) / static_cast<double>(values_.size() - 1)) -
                elementary::exp(-2.0));
    }
    [[nodiscard]] Real at(Real r2) const { return values_[static_cast<std::size_t>(r2 * Real(values_.size() - 1))]; }

  private:
    std::array<Real, 129> values_{};
};
const GaussianTable gaussian;

/// Most texels on either side. Ellipses reach two texels times the anisotropy. Only rows of very elongated images would
/// exceed this bound, where one texel covers a whole column.
constexpr Real most_reach = 64;

template <class T>
T read(const ImageSampler& sampler, const Vec2& st) {
    if constexpr (std::is_same_v<T, Rgb>) return sampler.rgb(st);
    else return sampler.real(st);
}
template <class T>
T read_texel(const ImageSampler& sampler, int x, int y) {
    if constexpr (std::is_same_v<T, Rgb>) return sampler.texel_rgb(x, y);
    else return sampler.texel_real(x, y);
}

}  // namespace

ImagePyramid ImagePyramid::of(const Image& image) {
    ImagePyramid pyramid;
    for (const Image* last = &image; last->width > 1 || last->height > 1; last = &pyramid.levels.back())
        pyramid.levels.push_back(half_of(*last));
    return pyramid;
}

template <class T, class LookUp>
T ImageFilter::between_levels(Real level, const LookUp& look_up) const {
    const auto last = static_cast<Real>(pyramid->levels.size());
    if (!(level > 0)) return look_up(std::size_t{0});
    if (!(level < last)) return look_up(pyramid->levels.size());
    const Real lower = std::floor(level), share = level - lower;
    const auto k = static_cast<std::size_t>(lower);
    return look_up(k) * (1 - share) + look_up(k + 1) * share;
}

template <class T>
T ImageFilter::look_up(const ImageSampler& sampler, const Vec2& st, TexelFootprint axes) const {
    if (pyramid == nullptr || kind == TextureFilter::unfiltered) return read<T>(sampler, st);
    const auto width = static_cast<Real>(sampler.image->width), height = static_cast<Real>(sampler.image->height);
    for (Vec2* axis : {&axes.first, &axes.second}) *axis = {axis->x * width, axis->y * height};
    if (kind == TextureFilter::ewa) return ellipse<T>(sampler, st, axes);
    const Real side = std::max(length_of(axes.first), length_of(axes.second));
    if (!(side > 1)) return read<T>(sampler, st);  // also for NaN
    const Real level = side < infinity ? elementary::log2(side) : infinity;
    if (kind == TextureFilter::trilinear)
        return between_levels<T>(level, [&](std::size_t k) { return read<T>(at_level(sampler, k), st); });
    const Real nearest = std::min(std::floor(level + Real(0.5)), static_cast<Real>(pyramid->levels.size()));
    return read<T>(at_level(sampler, static_cast<std::size_t>(nearest)), st);
}

// The ellipse A x^2 + B x y + C y^2 = F through the ends of both axes. A texel's own extent is added to A and C, so
// that the ellipse never falls between texels.
template <class T>
T ImageFilter::ellipse(const ImageSampler& sampler, const Vec2& st, TexelFootprint axes) const {
    Vec2 &a = axes.first, &b = axes.second;
    if (length_of(a) < length_of(b)) std::swap(a, b);
    const Real longer = length_of(a);
    Real shorter = length_of(b);
    if (!(longer > 0)) return read<T>(sampler, st);  // also for NaN
    if (!(longer < infinity)) return read<T>(at_level(sampler, pyramid->levels.size()), st);
    if (!(shorter * most_anisotropic >= longer)) {
        const Real wanted = longer / most_anisotropic;
        b = shorter > 0 ? Vec2{b.x * (wanted / shorter), b.y * (wanted / shorter)}
                        : Vec2{-a.y / most_anisotropic, a.x / most_anisotropic};
        shorter = wanted;
    }
    const Real level = shorter > 1 ? elementary::log2(shorter) : 0;
    return between_levels<T>(level, [&](std::size_t k) {
        const ImageSampler at = at_level(sampler, k);
        const Real x_scale = Real(at.image->width) / Real(sampler.image->width),
                   y_scale = Real(at.image->height) / Real(sampler.image->height);
        const Vec2 p{a.x * x_scale, a.y * y_scale}, q{b.x * x_scale, b.y * y_scale};
        const Real f_a = p.y * p.y + q.y * q.y + 1, f_b = -2 * (p.x * p.y + q.x * q.y), f_c = p.x * p.x + q.x * q.x + 1,
                   inverse = 1 / (f_a * f_c - f_b * f_b * Real(0.25));
        const Vec2 center = at.pixel_position(st);
        const Real reach_x = std::sqrt(f_c), reach_y = std::sqrt(f_a);
        if (!(reach_x < most_reach && reach_y < most_reach)) return read<T>(at, st);
        const int x0 = static_cast<int>(std::ceil(center.x - reach_x)), x1 = static_cast<int>(center.x + reach_x),
                  y0 = static_cast<int>(std::ceil(center.y - reach_y)), y1 = static_cast<int>(center.y + reach_y);
        T sum{};
        Real weights = 0;
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const Real dx = Real(x) - center.x, dy = Real(y) - center.y;
                const Real r2 = (f_a * dx * dx + f_b * dx * dy + f_c * dy * dy) * inverse;
                if (!(r2 < 1)) continue;
                const Real weight = gaussian.at(r2);
                sum += read_texel<T>(at, x, y) * weight;
                weights += weight;
            }
        return weights > 0 ? sum * (1 / weights) : read<T>(at, st);
    });
}

Rgb ImageFilter::rgb(const ImageSampler& sampler, const Vec2& st, const TexelFootprint& axes) const {
    return look_up<Rgb>(sampler, st, axes);
}
Real ImageFilter::real(const ImageSampler& sampler, const Vec2& st, const TexelFootprint& axes) const {
    return look_up<Real>(sampler, st, axes);
}

}  // namespace raylex::transport
