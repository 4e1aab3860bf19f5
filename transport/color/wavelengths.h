// Wavelengths of paths that cross an interface whose index of refraction depends on them.
//
// Everything else is transported as RGB. Such a path has one wavelength l, which its sample draws, and its contribution
// is multiplied, colour by colour, by w(l) = r(l) / p(l). r_c is the response of rendering colour c to the white of the
// scene's colour space W at l, divided by its integral: (A xyz(l))_c W(l), where A takes CIE XYZ through the film's
// sensor to the rendering space. The mean of w is (1, 1, 1). So an index that is the same for all wavelengths leaves
// the image unchanged, and a white light through a prism gives what a spectral renderer gives (pbrt-v4's white light
// has the spectrum W). A coloured light has the spectrum W times its RGB, colour by colour.
//
// The wavelength is the hero of Wilkie et al. 2014, "Hero Wavelength Spectral Sampling", without companions, which
// would be refracted elsewhere: pbrt-v4 carries four and ends all but one at such an interface, too
// (SampledWavelengths::TerminateSecondary). p is proportional to |r_R| + |r_G| + |r_B|, which makes |w_R| + |w_G| +
// |w_B| the same for all wavelengths. Spectral colours lie outside of RGB spaces, so single components of w may be
// negative.
#pragma once

#include <array>

#include "display/services/rgb.h"
#include "transport/color/color_context.h"
#include "transport/color/spectral_data.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// One wavelength that stands for all of them, and the weight of its light.
struct HeroWavelength {
    Real nm = 0;
    Rgb weight;
};

class WavelengthDistribution {
  public:
    explicit WavelengthDistribution(const ColorContext& color);

    /// Draws a wavelength with u in [0, 1).
    [[nodiscard]] HeroWavelength draw(Real u) const;
    /// The mean of `spectrum` over the wavelengths, weighted by r_c: its RGB value, colour by colour. The mean of 1 is
    /// 1.
    [[nodiscard]] Rgb mean(const VisibleSpectrum& spectrum) const;

  private:
    std::array<RgbD, visible_samples> responses_;                ///< r: over 1 nm around each visible sample
    std::array<double, visible_samples + 1> probability_below_;  ///< cumulative, for each sample
    std::array<Rgb, visible_samples> weights_;
};

/// An index of refraction that depends on the wavelength.
class IndexSpectrum {
  public:
    IndexSpectrum(const VisibleSpectrum& spectrum, const ColorContext& color);

    /// The index at `nm` (nanometres), linear between the visible samples.
    [[nodiscard]] Real at(Real nm) const;
    [[nodiscard]] Real least() const { return least_; }
    [[nodiscard]] Real most() const { return most_; }
    /// WavelengthDistribution::mean() of the index.
    [[nodiscard]] const Rgb& mean() const { return mean_; }

  private:
    std::array<Real, visible_samples> index_;
    Real least_, most_;
    Rgb mean_;
};

}  // namespace raylex::transport
