#include "display/output/denoise/tile_filter.h"

#include <algorithm>
#include <cmath>

namespace raylex::display {

namespace {

/// Noise within which patches, or features, count as equal: a factor of their variance.
constexpr float patch_tolerance = 0.64f, feature_tolerance = 0.36f;
/// Squared differences of features that count as noise.
constexpr float feature_floor = 0.05f;

/// exp(-x), within 0.07, with a bounded support.
float decay(float x) {
    const float y = std::max(0.0f, 1 - 0.25f * std::max(0.0f, x));
    return y * y * y * y;
}

/// Sums over windows of 2 radius + 1 pixels in one direction: `count` pixels at distance `step`, with sums from the
/// first whole window on.
void sum_windows(const float* from, float* to, int count, std::ptrdiff_t step, int radius) {
    for (int i = radius; i < count - radius; ++i) {
        float sum = 0;
        for (int k = -radius; k <= radius; ++k) sum += from[(i + k) * step];
        to[i * step] = sum;
    }
}

PixelRegion grown(const PixelRegion& region, int by) {
    return {region.x0 - by, region.y0 - by, region.x1 + by, region.y1 + by};
}

}  // namespace

TileFilter::TileFilter(const NoisyImage& image, const PixelRegion& kept)
    : image_(image),
      kept_(kept),
      estimated_(grown(kept, risk_radius)),
      read_(grown(estimated_, search_radius + patch_radius)),
      width_(estimated_.width()),
      height_(estimated_.height()),
      stride_(read_.width()) {
    const std::size_t area = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(read_.height());
    inside_.resize(area);
    for (int y = read_.y0, i = 0; y < read_.y1; ++y)
        for (int x = read_.x0; x < read_.x1; ++x, ++i)
            inside_[static_cast<std::size_t>(i)] =
                x >= 0 && y >= 0 && x < image.width && y < image.height ? 1.0f : 0.0f;
    distance_.resize(area);
    sums_.resize(area);
    for (const NoisyLayer& layer : image.layers) {
        LayerPlanes& planes = layers_.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
            planes.values[c] = cut(layer.values[c]);
            planes.variance[c] = cut(layer.variance[c]);
        }
    }
    for (const FilterFeature& feature : image.features) {
        features_.push_back(cut(feature.values));
        feature_noise_.push_back(feature.variance.empty() ? std::vector<float>(area) : cut(feature.variance));
    }
    const std::size_t count = searched * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    feature_weights_.resize(count);
    weights_.resize(count);
    const std::size_t terms = features_.size() + 3;
    moments_.resize(terms * (terms + 1) / 2 * static_cast<std::size_t>(width_));
    differences_.resize(2 * terms * static_cast<std::size_t>(width_));
    compare_features();
}

/// Pixels outside the image repeat its border.
std::vector<float> TileFilter::cut(std::span<const float> plane) const {
    std::vector<float> values;
    values.reserve(inside_.size());
    for (int y = read_.y0; y < read_.y1; ++y) {
        const float* row = &plane[static_cast<std::size_t>(std::clamp(y, 0, image_.height - 1)) *
                                  static_cast<std::size_t>(image_.width)];
        values.insert(values.end(), static_cast<std::size_t>(std::max(0, -read_.x0)), row[0]);
        values.insert(values.end(), row + std::max(0, read_.x0), row + std::min(image_.width, read_.x1));
        values.insert(values.end(), static_cast<std::size_t>(std::max(0, read_.x1 - image_.width)),
                      row[image_.width - 1]);
    }
    return values;
}

void TileFilter::compare_features() {
    constexpr float strict = 1 / feature_tolerance;
    constexpr int margin = search_radius + patch_radius;
    for (int dy = -search_radius, k = 0; dy <= search_radius; ++dy)
        for (int dx = -search_radius; dx <= search_radius; ++dx, ++k) {
            float* to = &feature_weights_[static_cast<std::size_t>(k * width_ * height_)];
            for (int y = 0; y < height_; ++y, to += width_) {
                const int at = (y + margin) * stride_ + margin, other = at + dy * stride_ + dx;
                const float* inside = &inside_[static_cast<std::size_t>(other)];
                for (int x = 0; x < width_; ++x) to[x] = 0;
                for (std::size_t f = 0; f < features_.size(); ++f) {
                    const float *p = &features_[f][static_cast<std::size_t>(at)], *q = p + (other - at);
                    const float *pv = &feature_noise_[f][static_cast<std::size_t>(at)], *qv = pv + (other - at);
                    for (int x = 0; x < width_; ++x) {
                        const float noise = pv[x] + qv[x], difference = p[x] - q[x];
                        to[x] = std::max(to[x], (difference * difference - noise) / (feature_floor + noise));
                    }
                }
                for (int x = 0; x < width_; ++x) to[x] = inside[x] * decay(strict * to[x]);
            }
        }
}

/// Sets distance_ to the mean distance of the patches around each pixel and around the one at (dx, dy) from it.
void TileFilter::compare_patches(const LayerPlanes& planes, int dx, int dy) {
    const int shift = dy * stride_ + dx;
    // the first pixels of all pairs with a pixel of estimated_, and their patches
    const int x0 = search_radius - std::max(0, dx), x1 = stride_ - search_radius - std::min(0, dx);
    const int y0 = search_radius - std::max(0, dy), y1 = read_.height() - search_radius - std::min(0, dy);
    for (int y = y0; y < y1; ++y) {
        const std::size_t row = static_cast<std::size_t>(y * stride_);
        float* to = &distance_[row];
        const auto& [r, g, b] = planes.values;
        const auto& [rv, gv, bv] = planes.variance;
        for (int x = x0; x < x1; ++x) {
            const std::size_t p = row + static_cast<std::size_t>(x), q = p + static_cast<std::size_t>(shift);
            const float red = r[p] - r[q], green = g[p] - g[q], blue = b[p] - b[q];
            const float noise = rv[p] + gv[p] + bv[p] + rv[q] + gv[q] + bv[q];
            to[x] = (red * red + green * green + blue * blue - noise) / (1e-30f + patch_tolerance * noise);
        }
        sum_windows(to + x0, &sums_[row + static_cast<std::size_t>(x0)], x1 - x0, 1, patch_radius);
    }
    constexpr float all = (2 * patch_radius + 1) * (2 * patch_radius + 1);
    for (int y = y0 + patch_radius; y < y1 - patch_radius; ++y) {
        float* to = &distance_[static_cast<std::size_t>(y * stride_)];
        for (int x = x0; x < x1; ++x) to[x] = 0;
        for (int k = -patch_radius; k <= patch_radius; ++k) {
            const float* from = &sums_[static_cast<std::size_t>((y + k) * stride_)];
            for (int x = x0; x < x1; ++x) to[x] += from[x];
        }
        for (int x = x0; x < x1; ++x) to[x] *= 1 / all;
    }
}

/// Distances are symmetric: with the sign -1 the pixel is the second one of the pair.
void TileFilter::set_weights(int dx, int dy, std::size_t offset, int sign) {
    constexpr int margin = search_radius + patch_radius;
    const std::size_t area = static_cast<std::size_t>(width_ * height_);
    for (int y = 0; y < height_; ++y) {
        const std::size_t row = static_cast<std::size_t>(y * width_);
        const int at = (y + margin) * stride_ + margin - (sign < 0 ? dy * stride_ + dx : 0);
        const float *from = &distance_[static_cast<std::size_t>(at)], *limit = &feature_weights_[offset * area + row];
        float* to = &weights_[offset * area + row];
        for (int x = 0; x < width_; ++x) to[x] = std::min(limit[x], decay(from[x]));
    }
}

bool TileFilter::weigh(std::size_t layer) {
    const LayerPlanes& planes = layers_[layer];
    const auto is_zero = [](const std::vector<float>& plane) {
        return std::all_of(plane.begin(), plane.end(), [](float value) { return value == 0; });
    };
    if (std::all_of(planes.variance.begin(), planes.variance.end(), is_zero)) return false;
    const std::size_t area = static_cast<std::size_t>(width_ * height_);
    std::copy_n(&feature_weights_[searched / 2 * area], area, &weights_[searched / 2 * area]);
    for (std::size_t k = searched / 2 + 1; k < searched; ++k) {
        const int dx = static_cast<int>(k) % search_side - search_radius,
                  dy = static_cast<int>(k) / search_side - search_radius;
        compare_patches(planes, dx, dy);
        set_weights(dx, dy, k, 1);
        set_weights(dx, dy, searched - 1 - k, -1);
    }
    if (layer == 0) regress();
    else normalize();
    return true;
}

/// Scales the weights of each pixel so that they sum to 1.
void TileFilter::normalize() {
    const std::size_t width = static_cast<std::size_t>(width_), area = width * static_cast<std::size_t>(height_);
    std::vector<float> total(width);
    for (std::size_t row = 0; row < area; row += width) {  // the weights of a row stay in the cache
        std::fill(total.begin(), total.end(), 0.0f);
        for (std::size_t k = 0; k < searched; ++k)
            for (std::size_t x = 0; x < width; ++x) total[x] += weights_[k * area + row + x];
        for (std::size_t k = 0; k < searched; ++k) {
            float* weights = &weights_[k * area + row];
            for (std::size_t x = 0; x < width; ++x) weights[x] = total[x] > 0 ? weights[x] / total[x] : 0.0f;
        }
    }
}

}  // namespace raylex::display
