// Metals in RGB: one complex index per colour, whose Fresnel reflectance has the colour of the spectral one.
//
// Means of eta and k under each colour's response would give another colour, since reflectance is not linear in them:
// gold at normal incidence would have 4.6 % too little red, 2.6 % too much green and 3.5 % too much blue.
#pragma once

#include "transport/color/spectral_data.h"
#include "transport/math/real.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct MetalIndex {
    Rgb eta, k;
};

/// The index of a metal under a medium of index `outside`; the result is not relative to `outside`. It is fitted by
/// least squares, over the cosine-weighted hemisphere, to the reflectance of the spectra as an albedo
/// (SpectrumRole::albedo). metal_index_test.cpp has the error for the named metals. The search begins at `means`, the
/// colours of the spectra as unbounded ones. Reflectances outside of the colour space, such as gold's red in sRGB,
/// count as 1.
[[nodiscard]] MetalIndex rgb_index_of_metal(const VisibleSpectrum& eta, const VisibleSpectrum& k,
                                            const MetalIndex& means, Real outside, const ColorContext& context);

}  // namespace raylex::transport
