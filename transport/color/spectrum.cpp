#include "transport/color/spectrum.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "lpe/input/read_input.h"
#include "transport/color/color_space.h"
#include "transport/color/spectral_data.h"

namespace raylex::transport {

namespace {

struct SampledSpectrum {
    std::vector<double> wavelengths, values;  ///< nm, strictly increasing
};

Rgb to_rgb(const Triple& v) {
    return {static_cast<Real>(v[0]), static_cast<Real>(v[1]), static_cast<Real>(v[2])};
}

/// Converts scene-space RGB to the rendering space and clamps it to the range of the role.
Rgb to_rendering(Triple rgb, SpectrumRole role, const ColorContext& context) {
    if (role == SpectrumRole::unbounded) return to_rgb(rgb);
    if (role == SpectrumRole::illuminant) rgb = multiply(context.sensor, rgb);
    rgb = multiply(context.rendering_from_scene, rgb);
    for (double& c : rgb) c = role == SpectrumRole::albedo ? std::clamp(c, 0.0, 1.0) : std::max(c, 0.0);
    return to_rgb(rgb);
}

Triple project_reflectance(const VisibleSpectrum& s, ColorSpace space) {
    VisibleSpectrum white{}, seen{};
    find_named_spectrum(white_spectrum_name(space), white);
    for (std::size_t i = 0; i < visible_samples; ++i) seen[i] = s[i] * white[i];
    Triple xyz = integrate_xyz(seen);
    const double norm = integrate_xyz(white)[1];
    for (double& c : xyz) c /= norm;
    return multiply(rgb_from_xyz(space), xyz);
}

Triple project_albedo(const VisibleSpectrum& s, ColorSpace space) {
    Triple rgb = project_reflectance(s, space);
    for (double& c : rgb) c = std::clamp(c, 0.0, 1.0);
    return rgb;
}

Triple project_unbounded(const VisibleSpectrum& s, ColorSpace space) {
    VisibleSpectrum white{};
    find_named_spectrum(white_spectrum_name(space), white);
    const MatchingFunctions& f = matching_functions();
    const Matrix3& m = rgb_from_xyz(space);
    const double floor = 0.25 * *std::min_element(s.begin(), s.end());
    Triple mean{};
    for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0, weight = 0;
        for (std::size_t i = 0; i < visible_samples; ++i) {
            const double response = (m[c][0] * f.x[i] + m[c][1] * f.y[i] + m[c][2] * f.z[i]) * white[i];
            sum += response * s[i];
            weight += response;
        }
        mean[c] = std::max(sum / weight, floor);
    }
    return mean;
}

/// RGB with Y = 1; black for a spectrum without luminance. Negative channels are set to 0 and the others are unchanged:
/// the positive channels equal those of pbrt-v4's film.
Triple project_illuminant(const VisibleSpectrum& s, ColorSpace space) {
    const Triple xyz = integrate_xyz(s);
    if (!(xyz[1] > 0)) return {0, 0, 0};
    Triple rgb = multiply(rgb_from_xyz(space), Triple{xyz[0] / xyz[1], 1, xyz[2] / xyz[1]});
    for (double& c : rgb) c = std::max(c, 0.0);
    return rgb;
}

bool is_flat(const VisibleSpectrum& s) {
    return std::all_of(s.begin(), s.end(), [&s](double v) { return v == s[0]; });
}

Rgb project(const VisibleSpectrum& s, SpectrumRole role, const ColorContext& context) {
    // A flat spectrum is exactly grey, without the rounding of four hundred products.
    if (role == SpectrumRole::illuminant)
        return to_rendering(project_illuminant(s, context.scene_space), role, context);
    if (is_flat(s)) return to_rendering({s[0], s[0], s[0]}, role, context);
    return to_rendering(role == SpectrumRole::albedo ? project_albedo(s, context.scene_space)
                                                     : project_unbounded(s, context.scene_space),
                        role, context);
}

/// `numbers` contains wavelength, value, wavelength, value ...
Result<SampledSpectrum> from_pairs(const std::vector<double>& numbers, const SourceLocation& where,
                                   const std::string& what) {
    if (numbers.empty() || numbers.size() % 2 != 0)
        return error_at(where, what + " has " + std::to_string(numbers.size()) +
                                   " numbers; expected pairs of wavelength (nm) and value");
    SampledSpectrum samples;
    for (std::size_t i = 0; i < numbers.size(); i += 2) {
        if (!std::isfinite(numbers[i]) || !std::isfinite(numbers[i + 1]))
            return error_at(where, what + ": pair " + std::to_string(i / 2) + " is not finite");
        if (std::max(std::abs(numbers[i]), std::abs(numbers[i + 1])) > double{std::numeric_limits<float>::max()})
            return error_at(where, what + ": pair " + std::to_string(i / 2) +
                                       " is beyond the range of float; expected less than 3.4e38");
        if (i > 0 && !(numbers[i] > numbers[i - 2])) {
            std::ostringstream text;
            text << what << ": wavelength " << numbers[i] << " follows " << numbers[i - 2]
                 << "; expected increasing wavelengths";
            return error_at(where, text.str());
        }
        samples.wavelengths.push_back(numbers[i]);
        samples.values.push_back(numbers[i + 1]);
    }
    return samples;
}

/// Reads a file of wavelength-value pairs; '#' starts a comment.
Result<SampledSpectrum> read_spd(const std::string& path) {
    Result<std::string> content = read_input(path, NamedBy::file, "a spectrum file");
    if (!content) return content.error();
    std::istringstream file(std::move(*content));
    std::vector<double> numbers;
    std::string line, word;
    for (int number = 1; std::getline(file, line); ++number) {
        if (const auto comment = line.find('#'); comment != std::string::npos) line.resize(comment);
        std::istringstream words(line);
        while (words >> word) {
            const char* begin = word.data() + (word[0] == '+' ? 1 : 0);
            const char* end = word.data() + word.size();
            double value = 0;
            const auto [stop, status] = std::from_chars(begin, end, value);
            if (status != std::errc() || stop != end)
                return Error{"found '" + word + "'; expected a number: wavelengths (nm) and values alternate",
                             path,
                             number,
                             0,
                             line,
                             {}};
            numbers.push_back(value);
        }
    }
    return from_pairs(numbers, {path, 0, 0}, "spectrum file");
}

std::string known_names_hint(std::string_view name) {
    const std::string near = nearest_name(name, named_spectra());
    std::string hint = near.empty() ? "" : "did you mean '" + near + "'? ";
    hint += "Known spectra:";
    for (const std::string& known : named_spectra()) hint += " " + known;
    return hint;
}

Result<Rgb> resolve_rgb(const Parameter& parameter, SpectrumRole role, const ColorContext& context) {
    if (parameter.numbers.size() != 3)
        return error_at(parameter.location, "'rgb " + parameter.name + "' has " +
                                                std::to_string(parameter.numbers.size()) + " numbers; expected 3");
    for (const double c : parameter.numbers) {
        if (!std::isfinite(c) || c < 0)
            return error_at(
                parameter.location,
                "'rgb " + parameter.name + "' has a negative or infinite component; expected numbers of at least 0");
        if (role == SpectrumRole::albedo && c > 1)
            return error_at(parameter.location,
                            "'rgb " + parameter.name + "' has a component above 1; expected a reflectance in [0, 1]");
    }
    return to_rendering({parameter.numbers[0], parameter.numbers[1], parameter.numbers[2]}, role, context);
}

Result<VisibleSpectrum> read_text(const Parameter& parameter, bool extend) {
    if (parameter.strings.size() != 1)
        return error_at(parameter.location, "'spectrum " + parameter.name + "' has " +
                                                std::to_string(parameter.strings.size()) + " names; expected one");
    const std::string& name = parameter.strings.front();
    VisibleSpectrum named{};
    if (find_named_spectrum(name, named)) return named;
    std::error_code status;
    if (!std::filesystem::exists(name, status))
        return error_at(parameter.location, "'" + name + "' is neither a named spectrum nor a readable file",
                        known_names_hint(name));
    Result<SampledSpectrum> samples = read_spd(name);
    if (!samples) return named_by(samples.error(), "'spectrum " + parameter.name + "'", parameter.location);
    return resample(samples->wavelengths, samples->values, extend);
}

/// Reads a blackbody or spectrum parameter. `extend`: see resample().
Result<VisibleSpectrum> read_spectrum(const Parameter& parameter, bool extend) {
    if (parameter.type == ParameterType::blackbody) {
        if (parameter.numbers.size() != 1 || !(parameter.numbers[0] > 0) || !std::isfinite(parameter.numbers[0]))
            return error_at(parameter.location,
                            "'blackbody " + parameter.name + "' expects one temperature in kelvin, above 0");
        return blackbody_spectrum(parameter.numbers[0]);
    }
    if (!parameter.strings.empty()) return read_text(parameter, extend);
    Result<SampledSpectrum> samples =
        from_pairs(parameter.numbers, parameter.location, "'spectrum " + parameter.name + "'");
    if (!samples) return samples.error();
    return resample(samples->wavelengths, samples->values, extend);
}

bool is_spectrum(const Parameter& parameter) {
    return parameter.type == ParameterType::blackbody || parameter.type == ParameterType::spectrum;
}

}  // namespace

Rgb recorded_light(const Rgb& light, const ColorContext& context) {
    return to_rendering({double{light.r}, double{light.g}, double{light.b}}, SpectrumRole::illuminant, context);
}

Result<Rgb> resolve_spectrum(const Parameter& parameter, SpectrumRole role, const ColorContext& context) {
    parameter.used = true;
    switch (parameter.type) {
        case ParameterType::rgb:
            return resolve_rgb(parameter, role, context);
        case ParameterType::blackbody:
        case ParameterType::spectrum: {
            const Result<VisibleSpectrum> spectrum = read_spectrum(parameter, role == SpectrumRole::unbounded);
            if (!spectrum) return spectrum.error();
            return project(*spectrum, role, context);
        }
        case ParameterType::real:
        case ParameterType::integer: {
            if (parameter.numbers.size() != 1 || !std::isfinite(parameter.numbers[0]) || parameter.numbers[0] < 0)
                return error_at(parameter.location,
                                "'" + parameter.name + "' expects one number of at least 0, or a colour");
            const double grey = parameter.numbers[0];
            return to_rendering({grey, grey, grey}, role, context);
        }
        default:
            break;
    }
    return error_at(parameter.location,
                    "'" + parameter.name + "' is not a colour; expected rgb, blackbody, spectrum or float");
}

Result<std::optional<VisibleSpectrum>> varying_spectrum(const Parameter& parameter) {
    if (!is_spectrum(parameter)) return std::optional<VisibleSpectrum>();
    const Result<VisibleSpectrum> spectrum = read_spectrum(parameter, true);
    if (!spectrum) return spectrum.error();
    return is_flat(*spectrum) ? std::optional<VisibleSpectrum>() : std::optional(*spectrum);
}

Result<Real> mean_of_spectrum(const Parameter& parameter, const ColorContext& context) {
    const Result<Rgb> rgb = resolve_spectrum(parameter, SpectrumRole::unbounded, context);
    if (!rgb) return rgb.error();
    return rgb->r == rgb->g && rgb->g == rgb->b ? rgb->r : rgb->average();
}

Result<Rgb> spectrum_or(const ParameterSet& parameters, std::string_view name, const Rgb& fallback, SpectrumRole role,
                        const ColorContext& context) {
    const Parameter* parameter = parameters.find(name);
    if (parameter == nullptr) return fallback;
    return resolve_spectrum(*parameter, role, context);
}

Result<Rgb> resolve_named_spectrum(std::string_view name, SpectrumRole role, const ColorContext& context) {
    VisibleSpectrum spectrum{};
    if (!find_named_spectrum(name, spectrum))
        return Error{"no spectrum is called '" + std::string(name) + "'", {}, 0, 0, {}, known_names_hint(name)};
    return project(spectrum, role, context);
}

Rgb blackbody_radiance(double kelvin, const ColorContext& context) {
    const VisibleSpectrum spectrum = blackbody_spectrum(kelvin);
    const double luminance = integrate_xyz(spectrum)[1];
    Triple rgb = project_illuminant(spectrum, context.scene_space);
    for (double& c : rgb) c *= luminance;
    return to_rendering(rgb, SpectrumRole::illuminant, context);
}

Result<Real> luminance_as_given(const Parameter& parameter) {
    VisibleSpectrum named{};
    if (!is_spectrum(parameter) ||
        (parameter.strings.size() == 1 && find_named_spectrum(parameter.strings.front(), named)))
        return Real(1);
    const Result<VisibleSpectrum> spectrum = read_spectrum(parameter, false);
    if (!spectrum) return spectrum.error();
    return static_cast<Real>(integrate_xyz(*spectrum)[1] / flat_luminance());
}

double flat_luminance() {
    VisibleSpectrum flat{};
    flat.fill(1);
    return integrate_xyz(flat)[1];
}

RgbD reflectance_color(const VisibleSpectrum& reflectance, const ColorContext& context) {
    const Triple rgb = multiply(context.rendering_from_scene, project_reflectance(reflectance, context.scene_space));
    return {rgb[0], rgb[1], rgb[2]};
}

std::vector<RgbD> reflectance_weights(const std::vector<double>& wavelengths, const ColorContext& context) {
    std::vector<RgbD> weights;
    std::vector<double> one(wavelengths.size(), 0.0);
    for (double& value : one) {
        value = 1;
        weights.push_back(reflectance_color(resample(wavelengths, one, false), context));
        value = 0;
    }
    return weights;
}

}  // namespace raylex::transport
