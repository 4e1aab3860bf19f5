#include "display/output/splits/rebuild.h"

#include <algorithm>
#include <cmath>

namespace raylex::display {

namespace {

constexpr std::size_t most_candidates = 256;

/// The layers of a sum that multiply something: of A * B it is B, unless A alone is a layer.
std::vector<const ImageLayer*> factors_of(const LayerSum& sum) {
    std::vector<const ImageLayer*> stack, factors;  // stack: the layer of a value that is a layer, else null
    for (const SumStep& step : sum.steps) {
        if (step.kind == SumStep::Kind::layer) {
            stack.push_back(step.layer);
            continue;
        }
        if (step.kind != SumStep::Kind::negate && step.kind != SumStep::Kind::rounded) {
            const ImageLayer* right = stack.back();
            stack.pop_back();
            const ImageLayer* factor = right != nullptr ? right : stack.back();
            if (step.kind == SumStep::Kind::multiply && factor != nullptr &&
                std::find(factors.begin(), factors.end(), factor) == factors.end())
                factors.push_back(factor);
        }
        stack.back() = nullptr;
    }
    return factors;
}

/// Returns an empty difference that any of the layers may explain.
LightDifference difference_of(const std::vector<const ImageLayer*>& layers) {
    LightDifference difference;
    for (const ImageLayer* layer : layers) difference.candidates.emplace_back(name_of(*layer), 0.0);
    return difference;
}

}  // namespace

void NegativeValues::add(const NegativeValues& more, int first_row) {
    const std::size_t all = pixels + more.pixels;
    if (more.lowest < lowest) *this = {0, more.lowest, more.x, more.y + first_row, more.layer};
    pixels = all;
}

std::string LightDifference::cause() const {
    constexpr double tolerance = 1e-4;  // 1 %, squared
    const auto least = std::min_element(candidates.begin(), candidates.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
    return pixels > 0 && least != candidates.end() && least->second <= tolerance * square ? least->first : "";
}

RebuildTally::RebuildTally(const ExrImage& image, const ImageLayer& of, const LayerSum& sum)
    : width_(static_cast<std::size_t>(image.width)),
      pixels_(width_ * static_cast<std::size_t>(image.height)),
      factors_(factors_of(sum)) {
    for (const ImageLayer& layer : image.layers) {
        const bool is_term = std::find(sum.layers.begin(), sum.layers.end(), &layer) != sum.layers.end();
        std::vector<const ImageLayer*>& layers = is_term ? terms_ : spare_;
        if (&layer != &of && layer.is_color() && layers.size() < most_candidates) layers.push_back(&layer);
    }
    for (const ImageLayer* layer : spare_) spare_planes_.push_back(layer->triple());
    for (const ImageLayer* layer : terms_) term_planes_.push_back(layer->triple());
    rebuild_.unassigned = difference_of(spare_);
    rebuild_.doubled = difference_of(terms_);
    for (const ImageLayer* factor : factors_) rebuild_.lost[name_of(*factor)];
}

void RebuildTally::add(std::size_t pixel, std::size_t c, double difference) {
    LightDifference& to = difference > 0 ? rebuild_.unassigned : rebuild_.doubled;
    const std::vector<std::array<const ImagePlane*, 3>>& candidates = difference > 0 ? spare_planes_ : term_planes_;
    const double light = std::abs(difference);
    to.light += light;
    to.square += light * light;
    if (light > to.largest) {
        to.largest = light;
        to.x = static_cast<int>(pixel % width_);
        to.y = static_cast<int>(pixel / width_);
    }
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        const double left = light - static_cast<double>(candidates[k][c]->values[pixel]);
        to.candidates[k].second += left * left;
    }
    for (const ImageLayer* factor : factors_)
        if (difference > 0 && factor->triple()[c]->values[pixel] == 0) rebuild_.lost[name_of(*factor)] += light;
    if (rebuild_.light.empty()) rebuild_.light.resize(3 * pixels_);
    rebuild_.light[3 * pixel + c] = static_cast<float>(difference);
}

void RebuildTally::add(std::size_t first, std::span<const std::array<SplitError, 3>> errors) {
    for (std::size_t i = 0; i < errors.size(); ++i) {
        bool is_missing = false, is_doubled = false;
        for (std::size_t c = 0; c < 3; ++c) {
            const SplitError& error = errors[i][c];
            if (!std::isfinite(error.scale) || !std::isfinite(error.absolute)) continue;
            rebuild_.whole += std::abs(error.whole);
            if (error.absolute <= error.allowed || error.open != 0) continue;
            add(first + i, c, error.whole - error.sum);
            (error.whole > error.sum ? is_missing : is_doubled) = true;
        }
        rebuild_.unassigned.pixels += is_missing ? 1 : 0;
        rebuild_.doubled.pixels += is_doubled ? 1 : 0;
    }
}

void add_rows(Rebuild& rebuild, const Rebuild& below, int first_row, std::size_t pixels, std::size_t pixels_below) {
    for (const auto part : {&Rebuild::unassigned, &Rebuild::doubled}) {
        LightDifference& to = rebuild.*part;
        const LightDifference& from = below.*part;
        if (from.largest > to.largest) {
            to.largest = from.largest;
            to.x = from.x;
            to.y = from.y + first_row;
        }
        to.light += from.light;
        to.square += from.square;
        to.pixels += from.pixels;
        for (std::size_t k = 0; k < to.candidates.size(); ++k) to.candidates[k].second += from.candidates[k].second;
    }
    rebuild.whole += below.whole;
    for (const auto& [factor, light] : below.lost) rebuild.lost[factor] += light;
    for (const auto& [layer, negative] : below.negative) rebuild.negative[layer].add(negative, first_row);
    if (rebuild.light.empty() && below.light.empty()) return;
    rebuild.light.resize(3 * pixels);
    rebuild.light.insert(rebuild.light.end(), below.light.begin(), below.light.end());
    rebuild.light.resize(3 * (pixels + pixels_below));
}

}  // namespace raylex::display
