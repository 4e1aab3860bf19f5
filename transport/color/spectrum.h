// Spectra to RGB. raylex transports RGB; what a scene gives as a spectrum is mapped once, at load.
#pragma once

#include <string_view>

#include "display/services/parameters.h"
#include "display/services/rgb.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// What a spectrum stands for decides how it becomes RGB.
enum class SpectrumRole : std::uint8_t {
    albedo,       ///< reflectance under the white of the colour space, clamped to [0, 1]
    unbounded,    ///< eta, k, sigma: mean under each primary's response; never converted between RGB spaces
    illuminant    ///< emission: luminance-normalised as pbrt does, then XYZ to RGB
};

/// Reads an rgb, blackbody or spectrum parameter (named, file, or wavelength-value pairs), or a single real as grey,
/// into the rendering space.
Result<Rgb> resolve_spectrum(const Parameter& parameter, SpectrumRole role, const ColorContext& context);

/// The parameter called `name`, resolved, or `fallback` when absent. The parameter is marked as used.
Result<Rgb> spectrum_or(const ParameterSet& parameters, std::string_view name, const Rgb& fallback, SpectrumRole role,
                        const ColorContext& context);

/// A named spectrum ("metal-Cu-eta", "glass-BK7", "stdillum-D65" ...).
Result<Rgb> resolve_named_spectrum(std::string_view name, SpectrumRole role, const ColorContext& context);

}  // namespace raylex::transport
