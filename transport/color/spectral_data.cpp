#include "transport/color/spectral_data.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"

namespace raylex::transport {

namespace {

struct MatchingRow {
    double x, y, z;
};

// CIE 1931 2-degree standard observer, 380 nm to 780 nm every 5 nm (CIE 15:2004, table T.4). The columns sum to
// 21.3714, 21.3711 and 21.3715, as CIE 15 states.
constexpr std::array<MatchingRow, 81> observer{{
    {0.001368, 0.000039, 0.006450}, {0.002236, 0.000064, 0.010550}, {0.004243, 0.000120, 0.020050},
    {0.007650, 0.000217, 0.036210}, {0.014310, 0.000396, 0.067850}, {0.023190, 0.000640, 0.110200},
    {0.043510, 0.001210, 0.207400}, {0.077630, 0.002180, 0.371300}, {0.134380, 0.004000, 0.645600},
    {0.214770, 0.007300, 1.039050}, {0.283900, 0.011600, 1.385600}, {0.328500, 0.016840, 1.622960},
    {0.348280, 0.023000, 1.747060}, {0.348060, 0.029800, 1.782600}, {0.336200, 0.038000, 1.772110},
    {0.318700, 0.048000, 1.744100}, {0.290800, 0.060000, 1.669200}, {0.251100, 0.073900, 1.528100},
    {0.195360, 0.090980, 1.287640}, {0.142100, 0.112600, 1.041900}, {0.095640, 0.139020, 0.812950},
    {0.057950, 0.169300, 0.616200}, {0.032010, 0.208020, 0.465180}, {0.014700, 0.258600, 0.353300},
    {0.004900, 0.323000, 0.272000}, {0.002400, 0.407300, 0.212300}, {0.009300, 0.503000, 0.158200},
    {0.029100, 0.608200, 0.111700}, {0.063270, 0.710000, 0.078250}, {0.109600, 0.793200, 0.057250},
    {0.165500, 0.862000, 0.042160}, {0.225750, 0.914850, 0.029840}, {0.290400, 0.954000, 0.020300},
    {0.359700, 0.980300, 0.013400}, {0.433450, 0.994950, 0.008750}, {0.512050, 1.000000, 0.005750},
    {0.594500, 0.995000, 0.003900}, {0.678400, 0.978600, 0.002750}, {0.762100, 0.952000, 0.002100},
    {0.842500, 0.915400, 0.001800}, {0.916300, 0.870000, 0.001650}, {0.978600, 0.816300, 0.001400},
    {1.026300, 0.757000, 0.001100}, {1.056700, 0.694900, 0.001000}, {1.062200, 0.631000, 0.000800},
    {1.045600, 0.566800, 0.000600}, {1.002600, 0.503000, 0.000340}, {0.938400, 0.441200, 0.000240},
    {0.854450, 0.381000, 0.000190}, {0.751400, 0.321000, 0.000100}, {0.642400, 0.265000, 0.000050},
    {0.541900, 0.217000, 0.000030}, {0.447900, 0.175000, 0.000020}, {0.360800, 0.138200, 0.000010},
    {0.283500, 0.107000, 0},        {0.218700, 0.081600, 0},        {0.164900, 0.061000, 0},
    {0.121200, 0.044580, 0},        {0.087400, 0.032000, 0},        {0.063600, 0.023200, 0},
    {0.046770, 0.017000, 0},        {0.032900, 0.011920, 0},        {0.022700, 0.008210, 0},
    {0.015840, 0.005723, 0},        {0.011359, 0.004102, 0},        {0.008111, 0.002929, 0},
    {0.005790, 0.002091, 0},        {0.004109, 0.001484, 0},        {0.002899, 0.001047, 0},
    {0.002049, 0.000740, 0},        {0.001440, 0.000520, 0},        {0.001000, 0.000361, 0},
    {0.000690, 0.000249, 0},        {0.000476, 0.000172, 0},        {0.000332, 0.000120, 0},
    {0.000235, 0.000085, 0},        {0.000166, 0.000060, 0},        {0.000117, 0.000042, 0},
    {0.000083, 0.000030, 0},        {0.000059, 0.000021, 0},        {0.000042, 0.000015, 0},
}};

struct DaylightRow {
    double s0, s1, s2;
};

// Daylight components S0, S1, S2, 380 nm to 780 nm every 10 nm (CIE 15:2004, table T.2).
constexpr std::array<DaylightRow, 41> daylight{{
    {63.4, 38.5, 3.0},   {65.8, 35.0, 1.2},   {94.8, 43.4, -1.1},  {104.8, 46.3, -0.5}, {105.9, 43.9, -0.7},
    {96.8, 37.1, -1.2},  {113.9, 36.7, -2.6}, {125.6, 35.9, -2.9}, {125.5, 32.6, -2.8}, {121.3, 27.9, -2.6},
    {121.3, 24.3, -2.6}, {113.5, 20.1, -1.8}, {113.1, 16.2, -1.5}, {110.8, 13.2, -1.3}, {106.5, 8.6, -1.2},
    {108.8, 6.1, -1.0},  {105.3, 4.2, -0.5},  {104.4, 1.9, -0.3},  {100.0, 0.0, 0.0},   {96.0, -1.6, 0.2},
    {95.1, -3.5, 0.5},   {89.1, -3.5, 2.1},   {90.5, -5.8, 3.2},   {90.3, -7.2, 4.1},   {88.4, -8.6, 4.7},
    {84.0, -9.5, 5.1},   {85.1, -10.9, 6.7},  {81.9, -10.7, 7.3},  {82.6, -12.0, 8.6},  {84.9, -14.0, 9.8},
    {81.3, -13.6, 10.2}, {71.9, -12.0, 8.3},  {74.3, -13.3, 9.6},  {76.4, -12.9, 8.5},  {63.3, -10.6, 7.0},
    {71.7, -11.6, 7.6},  {77.0, -12.2, 8.0},  {65.2, -10.2, 6.7},  {47.7, -7.8, 5.2},   {68.6, -11.2, 7.4},
    {65.0, -10.4, 6.8},
}};

}  // namespace

const MatchingFunctions& matching_functions() {
    static const MatchingFunctions functions = [] {
        MatchingFunctions f{};
        for (std::size_t i = 0; i < visible_samples; ++i) {
            const std::size_t row = std::min<std::size_t>(i / 5, observer.size() - 2);
            const double t = (static_cast<double>(i) - 5.0 * static_cast<double>(row)) / 5;
            const MatchingRow &a = observer[row], &b = observer[row + 1];
            f.x[i] = a.x + t * (b.x - a.x);
            f.y[i] = a.y + t * (b.y - a.y);
            f.z[i] = a.z + t * (b.z - a.z);
        }
        return f;
    }();
    return functions;
}

VisibleSpectrum resample(const std::vector<double>& wavelengths, const std::vector<double>& values, bool extend) {
    VisibleSpectrum result{};
    if (wavelengths.empty()) return result;
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const double lambda = visible_wavelength(i);
        if (lambda <= wavelengths.front() || lambda >= wavelengths.back()) {
            const bool low = lambda <= wavelengths.front();
            const bool inside = lambda == wavelengths.front() || lambda == wavelengths.back();
            if (inside || extend) result[i] = low ? values.front() : values.back();
            continue;
        }
        const auto upper = std::upper_bound(wavelengths.begin(), wavelengths.end(), lambda);
        const auto k = static_cast<std::size_t>(upper - wavelengths.begin());
        const double t = (lambda - wavelengths[k - 1]) / (wavelengths[k] - wavelengths[k - 1]);
        result[i] = values[k - 1] + t * (values[k] - values[k - 1]);
    }
    return result;
}

// Planck's law with the exact SI constants (CODATA 2018); the peak by Wien's displacement law.
VisibleSpectrum blackbody_spectrum(double kelvin) {
    constexpr double second_constant = 6.62607015e-34 * 299792458.0 / 1.380649e-23;  // h c / k, m K
    constexpr double wien = 2.897771955e-3;                                          // m K
    const auto radiance = [kelvin](double metres) {
        return elementary::pow(metres, -5) / elementary::expm1(second_constant / (metres * kelvin));
    };
    const double peak = radiance(wien / kelvin);
    VisibleSpectrum result{};
    for (std::size_t i = 0; i < visible_samples; ++i) result[i] = radiance(visible_wavelength(i) * 1e-9) / peak;
    return result;
}

VisibleSpectrum daylight_spectrum(double kelvin) {
    const double t = 1000 / kelvin;
    const double x = kelvin <= 7000 ? 0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
                                    : 0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064));
    const double y = -3 * x * x + 2.870 * x - 0.275;
    const double denominator = 0.0241 + 0.2562 * x - 0.7341 * y;
    const double m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / denominator;
    const double m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / denominator;
    VisibleSpectrum result{};
    for (std::size_t i = 0; i < visible_samples; ++i) {
        const std::size_t row = std::min<std::size_t>(i / 10, daylight.size() - 2);
        const double f = (static_cast<double>(i) - 10.0 * static_cast<double>(row)) / 10;
        const auto at = [&](const DaylightRow& r) { return r.s0 + m1 * r.s1 + m2 * r.s2; };
        result[i] = at(daylight[row]) + f * (at(daylight[row + 1]) - at(daylight[row]));
    }
    return result;
}

}  // namespace raylex::transport
