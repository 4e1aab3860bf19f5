// Metals in RGB: one complex index per colour, whose Fresnel reflectance has the colour of the spectral one.
//
// Means of eta and k under each colour's response are no such thing: reflectance is not linear in them (gold at normal
// incidence, 4.6 % too little red, 2.6 % too much green and 3.5 % too much blue).
#pragma once

#include "transport/color/spectral_data.h"
#include "transport/math/real.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct MetalIndex {
    Rgb eta, k;
};

/// Of a metal under a medium of index `outside`, to which the result is not yet relative. `means`: the spectra as
/// unbounded ones are resolved, where the search begins. Fitted by least squares over the cosine-weighted hemisphere to
/// the reflectance of the spectra as albedos are seen (SpectrumRole::albedo); how near it comes for the named metals
/// stands in metal_index_test.cpp. A colour that the space cannot hold, gold's red in sRGB, is taken for 1.
[[nodiscard]] MetalIndex rgb_index_of_metal(const VisibleSpectrum& eta, const VisibleSpectrum& k,
                                            const MetalIndex& means, Real outside, const ColorContext& context);

}  // namespace raylex::transport
