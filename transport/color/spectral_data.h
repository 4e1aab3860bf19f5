// Measured spectra: colour matching functions, daylight components, optical constants of metals and glasses.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace raylex::transport {

/// The wavelengths over which colours are summed: 380 nm to 780 nm, one sample per nm.
inline constexpr int visible_begin = 380, visible_end = 780;
inline constexpr std::size_t visible_samples = visible_end - visible_begin + 1;
using VisibleSpectrum = std::array<double, visible_samples>;
[[nodiscard]] constexpr double visible_wavelength(std::size_t sample) {
    return visible_begin + static_cast<double>(sample);
}

/// CIE 1931 2-degree colour matching functions, the 5 nm table interpolated linearly.
struct MatchingFunctions {
    VisibleSpectrum x, y, z;
};
[[nodiscard]] const MatchingFunctions& matching_functions();

/// Values of a piecewise linear spectrum at the visible samples. `wavelengths` (nm) increases strictly. Outside its
/// range the spectrum is 0 as in pbrt; with `extend` it keeps its end values.
[[nodiscard]] VisibleSpectrum resample(const std::vector<double>& wavelengths, const std::vector<double>& values,
                                       bool extend);

/// Planck's law at `kelvin`, divided by its maximum over all wavelengths.
[[nodiscard]] VisibleSpectrum blackbody_spectrum(double kelvin);
/// CIE daylight of a correlated colour temperature in 4000 ... 25000 K (CIE 15: S0 + M1 S1 + M2 S2).
[[nodiscard]] VisibleSpectrum daylight_spectrum(double kelvin);

/// Writes the spectrum called `name`; returns false if there is none.
bool find_named_spectrum(std::string_view name, VisibleSpectrum& spectrum);
[[nodiscard]] const std::vector<std::string>& named_spectra();

}  // namespace raylex::transport
