// Spectra that scene files refer to by pbrt-v4's names.
#include "display/services/elementary.h"
#include "transport/color/fluorescent_lamps.h"
#include "transport/color/spectral_data.h"

#include <cmath>
#include <iterator>
#include <span>

namespace raylex::transport {

namespace {

struct OpticalConstant {
    double n, k;
};

// Photon energies of the rows below: 3.4 eV down to 1.5 eV every 0.1 eV; wavelength = h c / energy.
constexpr double first_energy = 3.4, energy_step = 0.1, hc_in_ev_nm = 1239.84193;
using MetalRows = std::array<OpticalConstant, 20>;

// Ag, Al, Au: E. D. Palik (ed.), Handbook of Optical Constants of Solids, 1985, as scene files in this field use them;
// Cu: H.-J. Hagemann, W. Gudat, C. Kunz, DESY SR-74/7, 1974.
constexpr MetalRows silver{{{.186, 1.610}, {.200, 1.670}, {.192, 1.810}, {.173, 1.950}, {.173, 2.110},
                            {.160, 2.260}, {.157, 2.400}, {.144, 2.560}, {.132, 2.720}, {.130, 2.880},
                            {.130, 3.070}, {.129, 3.250}, {.120, 3.450}, {.121, 3.660}, {.131, 3.880},
                            {.140, 4.150}, {.140, 4.440}, {.148, 4.740}, {.143, 5.090}, {.145, 5.500}}};
constexpr MetalRows aluminium{{{.407, 4.430},  {.432, 4.560},  {.460, 4.710},  {.490, 4.860},  {.523, 5.020},
                               {.558, 5.200},  {.598, 5.380},  {.644, 5.580},  {.695, 5.800},  {.755, 6.030},
                               {.826, 6.280},  {.912, 6.550},  {1.020, 6.850}, {1.150, 7.150}, {1.300, 7.480},
                               {1.490, 7.820}, {1.740, 8.210}, {2.140, 8.570}, {2.630, 8.600}, {2.740, 8.310}}};
constexpr MetalRows gold{{{1.716, 1.862}, {1.696, 1.906}, {1.674, 1.936}, {1.658, 1.956}, {1.636, 1.958},
                          {1.616, 1.940}, {1.562, 1.904}, {1.426, 1.846}, {1.242, 1.796}, {.916, 1.840},
                          {.608, 2.120},  {.402, 2.540},  {.306, 2.880},  {.236, 2.970},  {.194, 3.060},
                          {.166, 3.150},  {.160, 3.800},  {.164, 4.357},  {.176, 4.860},  {.188, 5.390}}};
constexpr MetalRows copper{{{1.270, 1.950}, {1.225, 2.015}, {1.180, 2.210}, {1.175, 2.130}, {1.180, 2.210},
                            {1.175, 2.289}, {1.170, 2.362}, {1.160, 2.433}, {1.150, 2.504}, {1.135, 2.564},
                            {1.120, 2.605}, {1.040, 2.583}, {.826, 2.599},  {.468, 2.809},  {.272, 3.240},
                            {.214, 3.670},  {.213, 4.050},  {.223, 4.430},  {.250, 4.817},  {.260, 5.260}}};

struct ConstantRow {
    double nm, n, k;
};

// Brass, 70 % Cu and 30 % Zn: M. R. Querry, Optical constants, CRDC-CR-85034, 1985 (refractiveindex.info, CC0).
constexpr ConstantRow brass[] = {
    {360, 1.503, 1.815}, {380, 1.487, 1.818}, {400, 1.445, 1.805}, {410, 1.405, 1.794}, {420, 1.350, 1.786},
    {430, 1.278, 1.784}, {440, 1.191, 1.797}, {450, 1.094, 1.829}, {460, .994, 1.883},  {470, .900, 1.957},
    {480, .816, 2.046},  {490, .745, 2.145},  {500, .686, 2.250},  {520, .602, 2.464},  {540, .549, 2.668},
    {560, .505, 2.860},  {580, .468, 3.059},  {600, .450, 3.253},  {620, .449, 3.434},  {640, .444, 3.609},
    {660, .445, 3.778},  {680, .444, 3.943},  {700, .446, 4.106},  {720, .450, 4.266},  {740, .455, 4.424},
    {760, .458, 4.579},  {780, .464, 4.737},  {800, .473, 4.890},
};
// MgO: R. E. Stephens and I. H. Malitson 1952, by way of Palik; its absorption is below 1e-6 over the visible range.
constexpr ConstantRow magnesia[] = {
    {361, 1.77318, 0},   {382, 1.7668, 0},    {405, 1.76104, 0},   {430.9, 1.7557, 0},  {457.8, 1.7512, 0},
    {477.9, 1.7483, 0},  {499.9, 1.7454, 0},  {546.2, 1.74077, 0}, {589.3, 1.73737, 0}, {632.9, 1.7346, 0},
    {690.7, 1.73191, 0}, {767.7, 1.72872, 0}, {800, 1.7276, 0},
};
// TiO2 (rutile): Palik's handbook.
constexpr ConstantRow titania[] = {
    {360, 3.87, .251}, {388, 3.49, 0}, {400, 3.40, 0}, {412, 3.24, .022}, {420, 3.29, 0}, {440, 3.20, 0},
    {460, 3.13, 0},    {480, 3.08, 0}, {500, 3.03, 0}, {520, 3.00, 0},    {540, 2.97, 0}, {560, 2.94, 0},
    {580, 2.92, 0},    {600, 2.90, 0}, {620, 2.88, 0}, {640, 2.87, 0},    {660, 2.85, 0}, {680, 2.84, 0},
    {700, 2.83, 0},    {720, 2.82, 0}, {760, 2.81, 0}, {800, 2.79, 0},
};

// n^2 = 1 + sum b_i l^2 / (l^2 - c_i), l in micrometres (SCHOTT catalogue by way of refractiveindex.info, CC0).
struct Sellmeier {
    const char* name;
    std::array<double, 3> b, c;
};
constexpr Sellmeier glasses[] = {
    {"glass-BK7", {1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653}},
    {"glass-BAF10", {1.5851495, 0.143559385, 1.08521269}, {0.00926681282, 0.0424489805, 105.613573}},
    {"glass-FK51A", {0.971247817, 0.216901417, 0.904651666}, {0.00472301995, 0.0153575612, 168.68133}},
    {"glass-LASF9", {2.00029547, 0.298926886, 1.80691843}, {0.0121426017, 0.0538736236, 156.530829}},
    {"glass-F5", {1.52481889, 0.187085527, 1.42729015}, {0.011254756, 0.0588995392, 129.141675}},    // SF5
    {"glass-F10", {1.62153902, 0.256287842, 1.64447552}, {0.0122241457, 0.0595736775, 147.468793}},  // SF10
    {"glass-F11", {1.73759695, 0.313747346, 1.89878101}, {0.013188707, 0.0623068142, 155.23629}},    // SF11
};

VisibleSpectrum sample_metal(const MetalRows& rows, double OpticalConstant::*value) {
    std::vector<double> wavelengths, values;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        wavelengths.push_back(hc_in_ev_nm / (first_energy - energy_step * static_cast<double>(i)));
        values.push_back(rows[i].*value);
    }
    return resample(wavelengths, values, true);
}

VisibleSpectrum sample_rows(std::span<const ConstantRow> rows, double ConstantRow::*value) {
    std::vector<double> wavelengths, values;
    for (const ConstantRow& row : rows) {
        wavelengths.push_back(row.nm);
        values.push_back(row.*value);
    }
    return resample(wavelengths, values, true);
}

VisibleSpectrum sample_glass(const Sellmeier& glass) {
    VisibleSpectrum result{};
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const double l = visible_wavelength(i) * 1e-3, l2 = l * l;
        double n2 = 1;
        for (std::size_t k = 0; k < 3; ++k) n2 += glass.b[k] * l2 / (l2 - glass.c[k]);
        result[i] = std::sqrt(n2);
    }
    return result;
}

// CIE standard illuminant A is Planck's law with the constants of 1931 (CIE 15:2004, 3.1.1).
VisibleSpectrum illuminant_a() {
    VisibleSpectrum result{};
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const double lambda = visible_wavelength(i);
        result[i] = elementary::pow(560 / lambda, 5) * elementary::expm1(1.435e7 / (2848 * 560.0)) /
                    elementary::expm1(1.435e7 / (2848 * lambda));
    }
    return result;
}

VisibleSpectrum illuminant_e() {
    VisibleSpectrum result;
    result.fill(1);
    return result;
}

struct NamedSpectrum {
    const char* name;
    VisibleSpectrum (*make)();
};

// The revised radiation constant moves the nominal temperature of the D series by 1.4388 / 1.4380.
constexpr double revised = 1.4388 / 1.4380;

constexpr NamedSpectrum others[] = {
    {"stdillum-A", illuminant_a},
    {"stdillum-D50", [] { return daylight_spectrum(5000 * revised); }},
    {"stdillum-D55", [] { return daylight_spectrum(5500 * revised); }},
    {"stdillum-D65", [] { return daylight_spectrum(6500 * revised); }},
    {"stdillum-D75", [] { return daylight_spectrum(7500 * revised); }},
    {"stdillum-E", illuminant_e},
    {"stdillum-F1", [] { return fluorescent_lamp(1); }},
    {"stdillum-F2", [] { return fluorescent_lamp(2); }},
    {"stdillum-F3", [] { return fluorescent_lamp(3); }},
    {"stdillum-F4", [] { return fluorescent_lamp(4); }},
    {"stdillum-F5", [] { return fluorescent_lamp(5); }},
    {"stdillum-F6", [] { return fluorescent_lamp(6); }},
    {"stdillum-F7", [] { return fluorescent_lamp(7); }},
    {"stdillum-F8", [] { return fluorescent_lamp(8); }},
    {"stdillum-F9", [] { return fluorescent_lamp(9); }},
    {"stdillum-F10", [] { return fluorescent_lamp(10); }},
    {"stdillum-F11", [] { return fluorescent_lamp(11); }},
    {"stdillum-F12", [] { return fluorescent_lamp(12); }},
    {"illum-acesD60", [] { return daylight_spectrum(6000 * revised); }},
    {"metal-Ag-eta", [] { return sample_metal(silver, &OpticalConstant::n); }},
    {"metal-Ag-k", [] { return sample_metal(silver, &OpticalConstant::k); }},
    {"metal-Al-eta", [] { return sample_metal(aluminium, &OpticalConstant::n); }},
    {"metal-Al-k", [] { return sample_metal(aluminium, &OpticalConstant::k); }},
    {"metal-Au-eta", [] { return sample_metal(gold, &OpticalConstant::n); }},
    {"metal-Au-k", [] { return sample_metal(gold, &OpticalConstant::k); }},
    {"metal-Cu-eta", [] { return sample_metal(copper, &OpticalConstant::n); }},
    {"metal-Cu-k", [] { return sample_metal(copper, &OpticalConstant::k); }},
    {"metal-CuZn-eta", [] { return sample_rows(brass, &ConstantRow::n); }},
    {"metal-CuZn-k", [] { return sample_rows(brass, &ConstantRow::k); }},
    {"metal-MgO-eta", [] { return sample_rows(magnesia, &ConstantRow::n); }},
    {"metal-MgO-k", [] { return sample_rows(magnesia, &ConstantRow::k); }},
    {"metal-TiO2-eta", [] { return sample_rows(titania, &ConstantRow::n); }},
    {"metal-TiO2-k", [] { return sample_rows(titania, &ConstantRow::k); }},
};

}  // namespace

bool find_named_spectrum(std::string_view name, VisibleSpectrum& spectrum) {
    for (const Sellmeier& glass : glasses)
        if (name == glass.name) return spectrum = sample_glass(glass), true;
    for (const NamedSpectrum& other : others)
        if (name == other.name) return spectrum = other.make(), true;
    return false;
}

const std::vector<std::string>& named_spectra() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Sellmeier& glass : glasses) all.emplace_back(glass.name);
        for (const NamedSpectrum& other : others) all.emplace_back(other.name);
        return all;
    }();
    return names;
}

}  // namespace raylex::transport
