#include "transport/color/wavelengths.h"

#include <algorithm>
#include <cmath>

#include "transport/color/color_space.h"

namespace raylex::transport {
namespace {

std::array<RgbD, visible_samples> responses_of(const ColorContext& color) {
    VisibleSpectrum white{};
    find_named_spectrum(white_spectrum_name(color.scene_space), white);
    const Matrix3 from_xyz =
        multiply(color.rendering_from_scene, multiply(color.sensor, rgb_from_xyz(color.scene_space)));
    const MatchingFunctions& f = matching_functions();
    std::array<RgbD, visible_samples> responses;
    RgbD sum;
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const Triple rgb = multiply(from_xyz, Triple{f.x[i] * white[i], f.y[i] * white[i], f.z[i] * white[i]});
        responses[i] = {rgb[0], rgb[1], rgb[2]};
        sum += responses[i];
    }
    for (RgbD& each : responses) each = {each.r / sum.r, each.g / sum.g, each.b / sum.b};
    return responses;
}

double magnitude(const RgbD& c) {
    return std::abs(c.r) + std::abs(c.g) + std::abs(c.b);
}

}  // namespace

WavelengthDistribution::WavelengthDistribution(const ColorContext& color) : responses_(responses_of(color)) {
    double all = 0;
    for (const RgbD& each : responses_) all += magnitude(each);
    double below = 0;
    for (std::size_t i = 0; i < visible_samples; ++i) {
        probability_below_[i] = below / all;
        below += magnitude(responses_[i]);
        const double p = magnitude(responses_[i]) / all;
        weights_[i] = p > 0 ? Rgb(static_cast<Real>(responses_[i].r / p), static_cast<Real>(responses_[i].g / p),
                                  static_cast<Real>(responses_[i].b / p))
                            : Rgb();
    }
    probability_below_[visible_samples] = 1;
}

HeroWavelength WavelengthDistribution::draw(Real u) const {
    const auto above =
        std::upper_bound(probability_below_.begin() + 1, probability_below_.end() - 1, static_cast<double>(u));
    const auto i = static_cast<std::size_t>(above - probability_below_.begin()) - 1;
    // Within a sample, the wavelength is drawn uniformly.
    const double p = probability_below_[i + 1] - probability_below_[i];
    const double within = p > 0 ? (static_cast<double>(u) - probability_below_[i]) / p : 0.5;
    return {static_cast<Real>(visible_wavelength(i) - 0.5 + within), weights_[i]};
}

Rgb WavelengthDistribution::mean(const VisibleSpectrum& spectrum) const {
    RgbD sum;
    for (std::size_t i = 0; i < visible_samples; ++i) sum += responses_[i] * spectrum[i];
    return Rgb(sum);
}

IndexSpectrum::IndexSpectrum(const VisibleSpectrum& spectrum, const ColorContext& color)
    : mean_(WavelengthDistribution(color).mean(spectrum)) {
    std::transform(spectrum.begin(), spectrum.end(), index_.begin(), [](double n) { return static_cast<Real>(n); });
    least_ = *std::min_element(index_.begin(), index_.end());
    most_ = *std::max_element(index_.begin(), index_.end());
}

Real IndexSpectrum::at(Real nm) const {
    const Real place = std::clamp(nm - visible_begin, Real(0), Real(visible_samples - 1));
    const auto i = std::min(static_cast<std::size_t>(place), visible_samples - 2);
    return index_[i] + (index_[i + 1] - index_[i]) * (place - static_cast<Real>(i));
}

}  // namespace raylex::transport
