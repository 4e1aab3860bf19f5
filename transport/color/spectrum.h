// Spectra to RGB. raylex transports RGB; each spectrum of a scene is converted once, at load.
//
// All sums run over 380 ... 780 nm at 1 nm with the CIE 1931 2-degree functions x, y, z (5 nm table, linear between).
// M is the matrix from XYZ to the linear RGB of the scene's colour space, from its primaries and from its white W as a
// spectrum (D65; D60 for ACES2065-1) integrated by the same sums, so that white is exactly grey.
//
//   albedo      S:  rgb = M sum(S W xyz) / sum(W y), clamped to [0, 1]. A flat S gives that grey.
//   unbounded   S:  each channel is the mean of S under that channel's response to the white, (M xyz) W. A flat S gives
//                   exactly its value. The response has negative lobes, so a mean is raised to at least a quarter of
//                   the smallest sample. For metals the reflectance is fitted instead (materials/metal_index.h).
//   illuminant  S:  rgb = M sum(S xyz) / sum(S y), with negative channels (colours outside the space) raised to 0. The
//                   luminance may then exceed 1, as with pbrt-v4's positive channels. pbrt-v4 divides every light
//                   by the luminance of its spectrum, so a spectrum gives only the colour and "scale" (or "power")
//                   the amount: doubling all samples changes nothing.
//
// rgb parameters are in the scene's space and are used unchanged. A blackbody is Planck's law at that temperature.
// Sampled spectra are linear between their samples and 0 outside them as in pbrt; unbounded ones keep their end values,
// since an index of refraction of 0 is meaningless. Albedos and lights are then multiplied by `rendering_from_scene`.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "display/services/parameters.h"
#include "transport/color/color_context.h"
#include "transport/color/spectral_data.h"
#include "transport/math/real.h"

namespace raylex::transport {

/// The role of a spectrum, which decides how it becomes RGB.
enum class SpectrumRole : std::uint8_t {
    albedo,     ///< reflectance under the white of the colour space, clamped to [0, 1]
    unbounded,  ///< eta, k, sigma: mean under each primary's response; never converted between RGB spaces
    illuminant  ///< emission: luminance-normalised as pbrt does, then XYZ to RGB
};

/// Reads an rgb, blackbody or spectrum parameter (named, file, or wavelength-value pairs), or a single real as grey,
/// into the rendering space. Errors: negative rgb, an albedo above 1, odd or unsorted pairs, an unknown name or file.
Result<Rgb> resolve_spectrum(const Parameter& parameter, SpectrumRole role, const ColorContext& context);

/// The samples of an unbounded spectrum at the visible wavelengths, ends kept; nothing if it has one value, or three
/// (rgb). Errors: see resolve_spectrum().
Result<std::optional<VisibleSpectrum>> varying_spectrum(const Parameter& parameter);

/// The mean of the RGB of an unbounded spectrum.
Result<Real> mean_of_spectrum(const Parameter& parameter, const ColorContext& context);

/// Converts light, given as linear RGB of the scene's space, as illuminants are resolved: to what the film records, in
/// the rendering space.
Rgb recorded_light(const Rgb& light, const ColorContext& context);

/// The parameter called `name`, resolved, or `fallback` when absent. The parameter is marked as used.
Result<Rgb> spectrum_or(const ParameterSet& parameters, std::string_view name, const Rgb& fallback, SpectrumRole role,
                        const ColorContext& context);

/// The colour of a reflectance in the rendering space: computed like `albedo`, without the clamp.
RgbD reflectance_color(const VisibleSpectrum& reflectance, const ColorContext& context);

/// The weight of each sample of a piecewise linear reflectance in its RGB of the rendering space. The sum equals
/// reflectance_color(). `wavelengths` is in nm, ascending; outside of it the reflectance is 0.
std::vector<RgbD> reflectance_weights(const std::vector<double>& wavelengths, const ColorContext& context);

/// The luminance of a spectrum (a blackbody is divided by its maximum) over that of the flat spectrum 1. Resolving an
/// illuminant divides by it. 1 for rgb and for named spectra, which pbrt-v4 stores with that luminance.
Result<Real> luminance_as_given(const Parameter& parameter);

/// Radiance of a blackbody in media as in pbrt-v4: Planck's law over its maximum, integrated with the observer's
/// functions without dividing by the integral of y. RGB of the rendering space, converted like an `illuminant`.
Rgb blackbody_radiance(double kelvin, const ColorContext& context);
/// The integral of y: the value that pbrt-v4's film records for the flat spectrum 1.
double flat_luminance();

/// RGB of a named spectrum ("metal-Cu-eta", "glass-BK7", "stdillum-D65" ...).
Result<Rgb> resolve_named_spectrum(std::string_view name, SpectrumRole role, const ColorContext& context);

}  // namespace raylex::transport
