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

void conclude(SplitVerdict& verdict) {
    const bool fails = verdict.non_finite > 0 || verdict.exceeding > 0;
    const bool nothing_judged = verdict.pixels > 0 && verdict.judged() == 0;
    verdict.answer = fails                       ? SplitAnswer::does_not_hold
                     : nothing_judged            ? SplitAnswer::cannot_tell
                     : verdict.past_rounding > 0 ? SplitAnswer::holds_as_allowed
                                                 : SplitAnswer::holds_to_rounding;
    verdict.holds = !fails && !nothing_judged;
}

double residual_limit(double bound, const Allowance& allowance) {
    return std::min(bound + allowance.relative, 0.5);
}

VerdictTally::VerdictTally(int width, std::size_t pixels, double unit, const Allowance& allowance, bool with_residual)
    : width_(width), limit_(residual_limit(unit, allowance)) {
    verdict_.pixels = pixels;
    verdict_.bound = unit;
    verdict_.allowance = allowance;
    verdict_.never_above = true;
    if (with_residual) verdict_.residual.resize(pixels);
}

void mark_clamped(std::span<const float> values, StoredType type, std::vector<bool>& clamped) {
    const float largest = largest_of(type);
    if (!any_clamped(values, largest)) return;
    clamped.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) clamped[i] = clamped[i] || std::abs(values[i]) == largest;
}

void VerdictTally::add(std::size_t pixel, std::array<SplitError, 3> components, bool clamped) {
    SplitVerdict& verdict = verdict_;
    verdict.clamped += clamped ? 1 : 0;
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
            if (here.sum > here.whole || here.negative) verdict.never_above = false;
        }
        if (here.absolute > 0) {
            const double share = limit_ * here.absolute / here.allowed;
            worst = std::max(worst, here.absolute > here.allowed ? share : std::min(share, limit_));
        }
        if (here.absolute > verdict.largest_absolute) {
            verdict.largest_absolute = here.absolute;
            verdict.absolute_x = x;
            verdict.absolute_y = y;
        }
        if (const double relative = relative_error(here, verdict.bound); relative > verdict.largest_relative) {
            verdict.largest_relative = relative;
            verdict.relative_x = x;
            verdict.relative_y = y;
        }
    }
    if (!finite && verdict.non_finite++ == 0) {
        verdict.non_finite_x = x;
        verdict.non_finite_y = y;
    }
    verdict.exceeding += finite && exceeds ? 1 : 0;
    verdict.undecided += finite && !exceeds && undecided ? 1 : 0;
    verdict.past_rounding += finite && past && !exceeds ? 1 : 0;
    if (!verdict.residual.empty())
        verdict.residual[pixel] = finite ? static_cast<float>(worst) : std::numeric_limits<float>::infinity();
}

SplitVerdict VerdictTally::finish() {
    verdict_.never_above = verdict_.never_above && verdict_.exceeding > 0;
    conclude(verdict_);
    return std::move(verdict_);
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

SplitVerdict SplitSum::verdict(bool with_residual) const {
    const std::size_t count = whole_[0].size();
    VerdictTally tally(width_, count, unit_, {}, with_residual);
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

void add_rows(SplitVerdict& verdict, const SplitVerdict& below, int first_row) {
    const auto larger = [first_row](double& value, int& x, int& y, double other, int other_x, int other_y) {
        if (!(other > value)) return;
        value = other;
        x = other_x;
        y = other_y + first_row;
    };
    larger(verdict.largest_absolute, verdict.absolute_x, verdict.absolute_y, below.largest_absolute, below.absolute_x,
           below.absolute_y);
    larger(verdict.largest_relative, verdict.relative_x, verdict.relative_y, below.largest_relative, below.relative_x,
           below.relative_y);
    if (verdict.non_finite == 0 && below.non_finite > 0) {
        verdict.non_finite_x = below.non_finite_x;
        verdict.non_finite_y = below.non_finite_y + first_row;
        verdict.non_finite_layer = below.non_finite_layer;
    }
    // A band without exceeding pixels does not determine the side.
    if (verdict.exceeding == 0) verdict.never_above = below.never_above;
    else if (below.exceeding > 0) verdict.never_above = verdict.never_above && below.never_above;
    NegativeValues lower = below.negative;
    lower.pixels += verdict.negative.pixels;
    lower.y += first_row;
    if (lower.lowest < verdict.negative.lowest) verdict.negative = std::move(lower);
    else verdict.negative.pixels = lower.pixels;
    verdict.past_rounding += below.past_rounding;
    verdict.non_finite += below.non_finite;
    verdict.exceeding += below.exceeding;
    verdict.clamped += below.clamped;
    verdict.pixels += below.pixels;
    verdict.undecided += below.undecided;
    conclude(verdict);
    verdict.residual.insert(verdict.residual.end(), below.residual.begin(), below.residual.end());
}

std::string verdict_attribute(const SplitVerdict& verdict, std::size_t layer_count) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(),
                  "%s; largest relative error %.3g at (%d, %d), bound %.3g; %zu layers; %zu pixels beyond it, "
                  "%zu not finite, %zu clamped, %zu of %zu judged",
                  verdict.answer == SplitAnswer::cannot_tell ? "cannot tell: every pixel is clamped"
                  : verdict.holds                            ? "holds"
                                                             : "does not hold",
                  verdict.largest_relative, verdict.relative_x, verdict.relative_y, verdict.bound, layer_count,
                  verdict.exceeding, verdict.non_finite, verdict.clamped, verdict.judged(), verdict.pixels);
    return text.data();
}

}  // namespace raylex::display
