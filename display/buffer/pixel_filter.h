// Pixel filters: kernels that combine the samples around a pixel's centre into its value.
//
// A filter is a plain value: the product of two symmetric profiles, one per axis, each a table of linear pieces.
// sample() draws an offset by exact inversion of |profile| (importance mode: the sample then belongs to this pixel
// alone). evaluate() gives the kernel that these samples follow, so the two always agree. The density is |f| itself, so
// the weight f / pdf is a constant with a sign: exactly 1 for kernels without negative lobes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "display/services/registry.h"

namespace raylex::display {

/// An offset from the pixel centre, in pixels, and the weight of the sample; weights have mean 1.
struct FilterSample {
    float dx = 0, dy = 0;
    float weight = 1;
};

/// One axis of a filter: an even function on [-radius, radius], stored as `segments` linear pieces on [0, radius].
class FilterProfile {
  public:
    /// `profile` is evaluated at points of [0, radius] (pixels) and need not be normalised. At least two segments per
    /// oscillation are needed; 1 is exact for a constant or a triangle. The integral must be positive: see valid().
    FilterProfile(const std::function<double(double)>& profile, double radius, int segments);

    [[nodiscard]] bool valid() const { return !pieces_.empty(); }
    [[nodiscard]] float radius() const { return radius_; }
    [[nodiscard]] bool has_negative_lobes() const { return weight_ > 1.0f; }
    /// The kernel value per pixel; its integral over [-radius, radius] is 1.
    [[nodiscard]] float evaluate(float x) const;
    /// Inverts the distribution of |kernel|. It is monotone in u, so stratification is preserved. Multiplies `weight`
    /// by its factor.
    [[nodiscard]] float sample(float u, float& weight) const;

  private:
    struct Piece {
        float start, width;  // on [0, radius]
        float below;         // fraction of |kernel| on [0, start]
        float left, right;   // density at both ends: `below` grows by width * (left + right) / 2
        float sign;
    };
    static constexpr int guide_size = 256;
    float radius_ = 0, steps_per_pixel_ = 0;
    float weight_ = 1;                  // integral of |kernel| over integral of kernel
    std::vector<float> values_;         // kernel at equally spaced points of [0, radius]
    std::vector<Piece> pieces_;         // split at the zeros of the interpolated kernel
    std::vector<std::uint16_t> guide_;  // [fraction * guide_size] -> first piece that can contain it
};

class PixelFilter {
  public:
    PixelFilter(std::string name, FilterProfile x, FilterProfile y)
        : name_(std::move(name)), x_(std::move(x)), y_(std::move(y)) {}

    /// u and v are in [0, 1). Offsets lie within the radii; weights have mean 1 and are negative in negative lobes.
    [[nodiscard]] FilterSample sample(float u, float v) const {
        FilterSample result;
        float weight_x = 1, weight_y = 1;
        result.dx = x_.sample(u, weight_x);
        result.dy = y_.sample(v, weight_y);
        result.weight = weight_x * weight_y;
        return result;
    }
    /// Kernel value at an offset in pixels from the pixel centre, per square pixel. Its integral is 1; it is 0 outside
    /// the radii.
    [[nodiscard]] float evaluate(float dx, float dy) const { return x_.evaluate(dx) * y_.evaluate(dy); }
    [[nodiscard]] float radius_x() const { return x_.radius(); }
    [[nodiscard]] float radius_y() const { return y_.radius(); }
    [[nodiscard]] bool has_negative_lobes() const { return x_.has_negative_lobes() || y_.has_negative_lobes(); }
    [[nodiscard]] bool valid() const { return x_.valid() && y_.valid(); }
    [[nodiscard]] const std::string& name() const { return name_; }

  private:
    std::string name_;
    FilterProfile x_, y_;
};

using PixelFilterFactory = std::function<Result<PixelFilter>(const ParameterSet&)>;

/// box, triangle, gaussian, mitchell, blackman-harris and sinc, with pbrt-v4's parameter names and defaults.
Registry<PixelFilterFactory>& pixel_filter_registry();

/// Makes the filter of that name with these parameters. An error is at the set's location and lists the known filters.
Result<PixelFilter> make_pixel_filter(const std::string& name, const ParameterSet& parameters);

inline float FilterProfile::evaluate(float x) const {
    const float position = std::abs(x) * steps_per_pixel_;
    const std::size_t last = values_.size() - 1;
    if (!(position < static_cast<float>(last))) return 0.0f;
    const auto index = static_cast<std::size_t>(position);
    const float fraction = position - static_cast<float>(index);
    return values_[index] + fraction * (values_[index + 1] - values_[index]);
}

inline float FilterProfile::sample(float u, float& weight) const {
    const float signed_share = 2.0f * u - 1.0f;
    const float share = std::abs(signed_share);
    std::size_t piece =
        guide_[static_cast<std::size_t>(std::min(static_cast<int>(share * guide_size), guide_size - 1))];
    while (piece + 1 < pieces_.size() && pieces_[piece + 1].below <= share) ++piece;
    const Piece& p = pieces_[piece];
    // Solves left t + (right - left) t^2 / 2 = q in a form without cancellation.
    const float q = (share - p.below) / p.width;
    const float root = std::sqrt(std::max(0.0f, p.left * p.left + 2.0f * (p.right - p.left) * q));
    const float denominator = p.left + root;
    const float t = denominator > 0.0f ? std::min(2.0f * q / denominator, 1.0f) : 0.0f;
    weight = weight_ * p.sign;
    return std::copysign(p.start + t * p.width, signed_share);
}

}  // namespace raylex::display
