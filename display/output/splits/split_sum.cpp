#include "display/output/splits/split_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "display/output/splits/stored_precision.h"

namespace raylex::display {

namespace {

// A difference that only the spacing of the smallest numbers explains counts as a relative error of at most the bound.
double relative_error(const SplitError& error, double unit) {
    const double relative = error.scale > 0 ? error.absolute / error.scale : 0.0;
    return error.absolute > error.rounding ? relative : std::min(relative, unit);
}

bool any_clamped(std::span<const float> values, float largest) {
    bool any = false;  // without a branch, so that the compiler can vectorise it
    for (const float value : values) any |= std::abs(value) == largest;
    return any;
}

}  // namespace

void conclude(SplitResult& result) {
    const bool fails = result.non_finite > 0 || result.exceeding > 0;
    const bool nothing_checked = result.pixels > 0 && result.checked() == 0;
    result.answer = fails                      ? SplitAnswer::does_not_hold
                    : nothing_checked          ? SplitAnswer::cannot_tell
                    : result.past_rounding > 0 ? SplitAnswer::holds_as_allowed
                                               : SplitAnswer::holds_to_rounding;
    result.holds = !fails && !nothing_checked;
}

double residual_limit(double bound, const Allowance& allowance) {
    return std::min(bound + allowance.relative, 0.5);
}

ResultTally::ResultTally(int width, std::size_t pixels, double unit, const Allowance& allowance, bool with_residual)
    : width_(width), limit_(residual_limit(unit, allowance)) {
    result_.pixels = pixels;
    result_.bound = unit;
    result_.allowance = allowance;
    result_.never_above = true;
    if (with_residual) result_.residual.resize(pixels);
}

void mark_clamped(std::span<const float> values, StoredType type, std::vector<bool>& clamped) {
    const float largest = largest_of(type);
    if (!any_clamped(values, largest)) return;
    clamped.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) clamped[i] = clamped[i] || std::abs(values[i]) == largest;
}

void ResultTally::add(std::size_t pixel, std::array<SplitError, 3> components, bool clamped) {
    SplitResult& result = result_;
    result.clamped += clamped ? 1 : 0;
    bool undecided = false;
    for (SplitError& here : components) {
        if (here.open == 0 || !std::isfinite(here.absolute)) continue;
        // The true values can reduce a difference if they can deviate in the opposite direction.
        if ((here.open & (here.sum > here.whole ? open_below : open_above)) != 0) here.absolute = 0;
        undecided = undecided || here.absolute <= here.allowed;
    }
    const int x = static_cast<int>(pixel % static_cast<std::size_t>(width_)),
              y = static_cast<int>(pixel / static_cast<std::size_t>(width_));
    bool finite = true, past = false, exceeds = false;
    double worst = 0;
    for (const SplitError& here : components) {
        if (!std::isfinite(here.scale) || !std::isfinite(here.absolute)) {
            finite = false;
            continue;
        }
        past = past || here.absolute > here.rounding;
        if (here.absolute > here.allowed) {
            exceeds = true;
            if (here.sum > here.whole || here.negative) result.never_above = false;
        }
        if (here.absolute > 0) {
            const double share = limit_ * here.absolute / here.allowed;
            worst = std::max(worst, here.absolute > here.allowed ? share : std::min(share, limit_));
        }
        if (here.absolute > result.largest_absolute) {
            result.largest_absolute = here.absolute;
            result.absolute_x = x;
            result.absolute_y = y;
        }
        if (const double relative = relative_error(here, result.bound); relative > result.largest_relative) {
            result.largest_relative = relative;
            result.relative_x = x;
            result.relative_y = y;
        }
    }
    if (!finite && result.non_finite++ == 0) {
        result.non_finite_x = x;
        result.non_finite_y = y;
    }
    result.exceeding += finite && exceeds ? 1 : 0;
    result.undecided += finite && !exceeds && undecided ? 1 : 0;
    result.past_rounding += finite && past && !exceeds ? 1 : 0;
    if (!result.residual.empty())
        result.residual[pixel] = finite ? static_cast<float>(worst) : std::numeric_limits<float>::infinity();
}

SplitResult ResultTally::finish() {
    result_.never_above = result_.never_above && result_.exceeding > 0;
    conclude(result_);
    return std::move(result_);
}

SplitSum::SplitSum(int width, int height, double cancelled) : width_(width), spacing_(cancelled) {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (std::size_t c = 0; c < 3; ++c) {
        sum_[c].resize(count);
        scale_[c].resize(count);
    }
}

void SplitSum::note(const SplitLayer& layer, bool whole) {
    for (std::size_t c = 0; c < 3; ++c) {
        const float largest = largest_of(layer.types[c]);
        if (!any_clamped(layer.planes[c], largest)) continue;
        for (std::size_t i = 0; i < layer.planes[c].size(); ++i) {
            const Open open = open_of(layer.planes[c][i], largest);
            if (open == 0) continue;
            open_[c].resize(layer.planes[c].size());
            open_[c][i] |= whole ? negated(open) : open;
        }
    }
    double spacing = 0;
    for (const StoredType type : layer.types) {
        const StoredPrecision precision = precision_of(type);
        unit_ = std::max(unit_, precision.unit);
        spacing = std::max(spacing, precision.spacing);
    }
    spacing_ += spacing;
}

void SplitSum::add(const SplitLayer& layer) {
    note(layer, false);
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
    note(layer, true);
    for (std::size_t c = 0; c < 3; ++c) whole_[c].assign(layer.planes[c].begin(), layer.planes[c].end());
}

SplitResult SplitSum::result(bool with_residual) const {
    const std::size_t count = whole_[0].size();
    ResultTally tally(width_, count, unit_, {}, with_residual);
    for (std::size_t pixel = 0; pixel < count; ++pixel) {
        std::array<SplitError, 3> errors;
        bool clamped = false;
        for (std::size_t c = 0; c < 3; ++c) {
            const double sum = sum_[c][pixel], whole = static_cast<double>(whole_[c][pixel]);
            const double scale = scale_[c][pixel] + std::abs(whole), rounding = unit_ * scale + spacing_;
            errors[c] = {std::abs(sum - whole), scale, rounding, rounding, sum, whole};
            if (!open_[c].empty()) errors[c].open = open_[c][pixel];
            clamped = clamped || errors[c].open != 0;
        }
        tally.add(pixel, errors, clamped);
    }
    return tally.finish();
}

void add_rows(SplitResult& result, const SplitResult& below, int first_row) {
    const auto larger = [first_row](double& value, int& x, int& y, double other, int other_x, int other_y) {
        if (!(other > value)) return;
        value = other;
        x = other_x;
        y = other_y + first_row;
    };
    larger(result.largest_absolute, result.absolute_x, result.absolute_y, below.largest_absolute, below.absolute_x,
           below.absolute_y);
    larger(result.largest_relative, result.relative_x, result.relative_y, below.largest_relative, below.relative_x,
           below.relative_y);
    if (result.non_finite == 0 && below.non_finite > 0) {
        result.non_finite_x = below.non_finite_x;
        result.non_finite_y = below.non_finite_y + first_row;
        result.non_finite_layer = below.non_finite_layer;
    }
    // A band without exceeding pixels does not determine the side.
    if (result.exceeding == 0) result.never_above = below.never_above;
    else if (below.exceeding > 0) result.never_above = result.never_above && below.never_above;
    result.negative.add(below.negative, first_row);
    add_rows(result.rebuild, below.rebuild, first_row, result.pixels, below.pixels);
    result.past_rounding += below.past_rounding;
    result.non_finite += below.non_finite;
    result.exceeding += below.exceeding;
    result.clamped += below.clamped;
    result.pixels += below.pixels;
    result.undecided += below.undecided;
    conclude(result);
    result.residual.insert(result.residual.end(), below.residual.begin(), below.residual.end());
}

std::string result_attribute(const SplitResult& result, std::size_t layer_count) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(),
                  "%s; largest relative error %.3g at (%d, %d), bound %.3g; %zu layers; %zu pixels beyond it, "
                  "%zu not finite, %zu clamped, %zu of %zu judged",
                  result.answer == SplitAnswer::cannot_tell ? "cannot tell: every pixel is clamped"
                  : result.holds                            ? "holds"
                                                            : "does not hold",
                  result.largest_relative, result.relative_x, result.relative_y, result.bound, layer_count,
                  result.exceeding, result.non_finite, result.clamped, result.checked(), result.pixels);
    return text.data();
}

}  // namespace raylex::display
