// Wavelengths of paths that cross an interface whose index of refraction depends on them.
//
// Everything else is transported as RGB. Such a path is of one wavelength l, which its sample draws, and what it brings
// counts by w(l) = r(l) / p(l), colour by colour. r_c is the response of rendering colour c to the white of the scene's
// colour space W at l, (A xyz(l))_c W(l) with A the way from CIE XYZ through the film's sensor to the rendering space,
// divided by its integral: the mean of w is (1, 1, 1), so that where the index is the same everywhere so is the image,
// and what a white light makes of a prism is what a spectral renderer makes of it (pbrt-v4's white light has the
// spectrum W). A coloured light has W times its RGB, colour by colour, for its spectrum.
//
// The wavelength is the hero of Wilkie et al. 2014, "Hero Wavelength Spectral Sampling", alone: others would be
// refracted elsewhere, and where pbrt-v4 carries four of them it ends all but one at such an interface, too
// (SampledWavelengths::TerminateSecondary). p is in proportion to |r_R| + |r_G| + |r_B|, which makes |w_R| + |w_G| +
// |w_B| the same for all wavelengths. Spectral colours lie outside of RGB spaces, so single components of w may be
// negative.
#pragma once

#include <array>

#include "display/services/rgb.h"
#include "transport/color/color_context.h"
#include "transport/color/spectral_data.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// One wavelength in place of all of them, and what its light counts for.
struct HeroWavelength {
    Real nm = 0;
    Rgb weight;
};

class WavelengthDistribution {
  public:
    explicit WavelengthDistribution(const ColorContext& color);

    /// u in [0, 1).
    [[nodiscard]] HeroWavelength draw(Real u) const;
    /// Mean over the wavelengths by r_c: what RGB makes of `spectrum`, colour by colour. That of 1 is 1.
    [[nodiscard]] Rgb mean(const VisibleSpectrum& spectrum) const;

  private:
    std::array<RgbD, visible_samples> responses_;                ///< r: of 1 nm around each visible sample
    std::array<double, visible_samples + 1> probability_below_;  ///< the sample
    std::array<Rgb, visible_samples> weights_;
};

/// An index of refraction that depends on the wavelength.
class IndexSpectrum {
  public:
    IndexSpectrum(const VisibleSpectrum& spectrum, const ColorContext& color);

    /// Linear between the visible samples.
    [[nodiscard]] Real at(Real nm) const;
    [[nodiscard]] Real least() const { return least_; }
    [[nodiscard]] Real most() const { return most_; }
    /// WavelengthDistribution::mean() of it.
    [[nodiscard]] const Rgb& mean() const { return mean_; }

  private:
    std::array<Real, visible_samples> index_;
    Real least_, most_;
    Rgb mean_;
};

}  // namespace raylex::transport
