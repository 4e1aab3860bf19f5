// Spectra to RGB. raylex transports RGB; what a scene gives as a spectrum is mapped once, at load.
//
// All sums run over 380 ... 780 nm at 1 nm with the CIE 1931 2-degree functions x, y, z (5 nm table, linear between).
// M is the matrix from XYZ to the linear RGB of the scene's colour space, from its primaries and from its white W as a
// spectrum (D65; D60 for ACES2065-1) integrated by the same sums, so that white is exactly grey.
//
//   albedo      S:  rgb = M sum(S W xyz) / sum(W y), clamped to [0, 1]. A flat S gives that grey.
//   unbounded   S:  each channel is the mean of S under that channel's response to the white, (M xyz) W. A flat S gives
//                   exactly its value. The response has negative lobes; a mean is never let below a quarter of the
//                   smallest sample. Of metals the reflectance is fitted instead (materials/metal_index.h).
//   illuminant  S:  rgb = M sum(S xyz) / sum(S y), negative channels (colours outside the space) raised to 0: what is
//                   left has a luminance above 1 then, as pbrt-v4's positive channels have. pbrt-v4 divides every light
//                   by the luminance of its spectrum, so a spectrum gives the colour alone and "scale" (or "power") the
//                   amount: doubling all samples changes nothing.
//
// rgb parameters stand in the scene's space and are used as they are. A blackbody is Planck's law at that temperature.
// Sampled spectra are linear between their samples and 0 outside them as in pbrt; unbounded ones keep their end values,
// since an index of refraction of 0 means nothing. Albedos and lights then go through `rendering_from_scene`.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "display/services/parameters.h"
#include "transport/color/color_context.h"
#include "transport/color/spectral_data.h"
#include "transport/math/real.h"

namespace raylex::transport {

/// What a spectrum stands for decides how it becomes RGB.
enum class SpectrumRole : std::uint8_t {
    albedo,     ///< reflectance under the white of the colour space, clamped to [0, 1]
    unbounded,  ///< eta, k, sigma: mean under each primary's response; never converted between RGB spaces
    illuminant  ///< emission: luminance-normalised as pbrt does, then XYZ to RGB
};

/// Reads an rgb, blackbody or spectrum parameter (named, file, or wavelength-value pairs), or a single real as grey,
/// into the rendering space. Errors: negative rgb, an albedo above 1, odd or unsorted pairs, an unknown name or file.
Result<Rgb> resolve_spectrum(const Parameter& parameter, SpectrumRole role, const ColorContext& context);

/// An unbounded spectrum as it is, at the visible samples, ends kept; nothing where it has one value, or three (rgb).
/// Errors as resolve_spectrum's.
Result<std::optional<VisibleSpectrum>> varying_spectrum(const Parameter& parameter);

/// One number for an unbounded spectrum: the mean of its RGB.
Result<Real> mean_of_spectrum(const Parameter& parameter, const ColorContext& context);

/// Light of linear RGB in the scene's space as illuminants are resolved: as the film records it, in the rendering
/// space.
Rgb recorded_light(const Rgb& light, const ColorContext& context);

/// The parameter called `name`, resolved, or `fallback` when absent. The parameter is marked as used.
Result<Rgb> spectrum_or(const ParameterSet& parameters, std::string_view name, const Rgb& fallback, SpectrumRole role,
                        const ColorContext& context);

/// The colour of a reflectance in the rendering space: as `albedo`, but without its clamp.
RgbD reflectance_color(const VisibleSpectrum& reflectance, const ColorContext& context);

/// What each sample of a piecewise linear reflectance adds to its RGB in the rendering space: as `albedo`, but linear,
/// without its clamp. `wavelengths` in nm, ascending; outside of them the reflectance is 0.
std::vector<RgbD> reflectance_weights(const std::vector<double>& wavelengths, const ColorContext& context);

/// The luminance of a spectrum, of a black body by its peak, over that of the flat spectrum 1: what illuminants lose
/// when they are resolved. 1 for rgb and for named spectra, which pbrt-v4 has in that size.
Result<Real> luminance_as_given(const Parameter& parameter);

/// Radiance of a black body as media have it in pbrt-v4: Planck's law over its peak, integrated by the observer's
/// functions without dividing by the integral of y. RGB of the rendering space, as `illuminant`.
Rgb blackbody_radiance(double kelvin, const ColorContext& context);
/// That integral: what pbrt-v4's film makes of the flat spectrum 1.
double flat_luminance();

/// A named spectrum ("metal-Cu-eta", "glass-BK7", "stdillum-D65" ...).
Result<Rgb> resolve_named_spectrum(std::string_view name, SpectrumRole role, const ColorContext& context);

}  // namespace raylex::transport
