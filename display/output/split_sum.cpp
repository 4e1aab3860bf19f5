#include "display/output/split_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace raylex::display {

namespace {

double unit_of(StoredType type) {
    return type == StoredType::half_float ? 0x1p-10 : 0x1p-23;
}
double spacing_of(StoredType type) {
    return type == StoredType::half_float ? 0x1p-24 : 0x1p-149;
}

struct Difference {
    double absolute = 0, relative = 0;
    bool finite = true, exceeds = false;
};

Difference difference(double sum, double scale, double whole, double unit, double spacing) {
    Difference result;
    scale += std::abs(whole);
    result.finite = std::isfinite(scale);
    if (!result.finite) return result;
    result.absolute = std::abs(sum - whole);
    result.relative = scale > 0 ? result.absolute / scale : 0.0;
    result.exceeds = result.absolute > unit * scale + spacing;
    if (!result.exceeds) result.relative = std::min(result.relative, unit);
    return result;
}

}  // namespace

SplitSum::SplitSum(int width, int height) : width_(width) {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (std::size_t c = 0; c < 3; ++c) {
        sum_[c].resize(count);
        scale_[c].resize(count);
    }
}

void SplitSum::note_types(const SplitLayer& layer) {
    double spacing = 0;
    for (const StoredType type : layer.types) {
        unit_ = std::max(unit_, unit_of(type));
        spacing = std::max(spacing, spacing_of(type));
    }
    spacing_ += spacing;
}

void SplitSum::add(const SplitLayer& layer) {
    note_types(layer);
    for (std::size_t c = 0; c < 3; ++c) {
        double* sum = sum_[c].data();
        double* scale = scale_[c].data();
        const float* values = layer.planes[c].data();
        for (std::size_t i = 0; i < sum_[c].size(); ++i) {
            const auto value = static_cast<double>(values[i]);
            sum[i] += value;
            scale[i] += std::abs(value);
        }
    }
}

void SplitSum::add_whole(const SplitLayer& layer) {
    note_types(layer);
    for (std::size_t c = 0; c < 3; ++c) whole_[c].assign(layer.planes[c].begin(), layer.planes[c].end());
}

SplitVerdict SplitSum::verdict(bool with_residual) const {
    SplitVerdict verdict;
    verdict.bound = unit_;
    const std::size_t count = whole_[0].size();
    if (with_residual) verdict.residual.resize(count);
    for (std::size_t pixel = 0; pixel < count; ++pixel) {
        const int x = static_cast<int>(pixel % static_cast<std::size_t>(width_)),
                  y = static_cast<int>(pixel / static_cast<std::size_t>(width_));
        bool finite = true, exceeds = false;
        double worst = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const Difference here = difference(sum_[c][pixel], scale_[c][pixel], static_cast<double>(whole_[c][pixel]),
                                               unit_, spacing_);
            finite = finite && here.finite;
            exceeds = exceeds || here.exceeds;
            worst = std::max(worst, here.relative);
            if (here.absolute > verdict.largest_absolute) {
                verdict.largest_absolute = here.absolute;
                verdict.absolute_x = x;
                verdict.absolute_y = y;
            }
            if (here.relative > verdict.largest_relative) {
                verdict.largest_relative = here.relative;
                verdict.relative_x = x;
                verdict.relative_y = y;
            }
        }
        if (!finite && verdict.non_finite++ == 0) {
            verdict.non_finite_x = x;
            verdict.non_finite_y = y;
        }
        verdict.exceeding += finite && exceeds ? 1 : 0;
        if (with_residual)
            verdict.residual[pixel] = finite ? static_cast<float>(worst) : std::numeric_limits<float>::infinity();
    }
    verdict.holds = verdict.non_finite == 0 && verdict.exceeding == 0;
    return verdict;
}

std::string verdict_attribute(const SplitVerdict& verdict, std::size_t layer_count) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(),
                  "%s; largest relative error %.3g at (%d, %d), bound %.3g; %zu layers; %zu pixels beyond it, "
                  "%zu not finite",
                  verdict.holds ? "holds" : "does not hold", verdict.largest_relative, verdict.relative_x,
                  verdict.relative_y, verdict.bound, layer_count, verdict.exceeding, verdict.non_finite);
    return text.data();
}

}  // namespace raylex::display
