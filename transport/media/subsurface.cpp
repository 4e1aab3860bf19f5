#include "transport/media/subsurface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "display/services/elementary.h"
#include "transport/math/fresnel.h"

namespace raylex::transport {

namespace {

constexpr double quarter_pi_inverse = 0.079577471545947673;  // 1 / (4 pi)
constexpr int beam_samples = 64;

double leaving_reflectance(double cosine, double eta) {
    return static_cast<double>(fresnel_dielectric(static_cast<Real>(cosine), static_cast<Real>(1 / eta)));
}

/// Integral of the inner reflectance times cosine^n over cosines.
double fresnel_moment(int n, double eta) {
    constexpr int steps = 512;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double mu = (i + 0.5) / steps;
        sum += leaving_reflectance(mu, eta) * (n == 1 ? mu : mu * mu);
    }
    return sum / steps;
}

/// A half space with extinction 1.
struct HalfSpace {
    double albedo, g, eta, moment1, moment2;

    [[nodiscard]] double multiple(double r) const;
    [[nodiscard]] double single(double r) const;
    [[nodiscard]] double reflectance() const;
};

/// Radiant exitance at distance r from a beam that enters perpendicularly, by light scattered more than once: dipoles
/// along the beam (Habel et al., sections 4 and 5).
double HalfSpace::multiple(double r) const {
    const double sigma_a = 1 - albedo, reduced = albedo * (1 - g), extinction = sigma_a + reduced;
    if (!(reduced > 0)) return 0;
    const double diffusion = (2 * sigma_a + reduced) / (3 * extinction * extinction);
    const double transport = std::sqrt(sigma_a / diffusion), reduced_albedo = reduced / extinction;
    const double boundary = -2 * diffusion * (1 + 3 * moment2) / (1 - 2 * moment1);
    const double of_fluence = 0.25 * (1 - 2 * moment1), of_irradiance = 0.5 * (1 - 3 * moment2);
    double sum = 0;
    for (int i = 0; i < beam_samples; ++i) {
        const double z = -elementary::log(1 - (i + 0.5) / beam_samples) / extinction, mirrored = -z + 2 * boundary;
        const double near = std::sqrt(r * r + z * z), far = std::sqrt(r * r + mirrored * mirrored);
        const double e_near = elementary::exp(-transport * near), e_far = elementary::exp(-transport * far);
        const double fluence = quarter_pi_inverse / diffusion * (e_near / near - e_far / far);
        const double irradiance = quarter_pi_inverse * (z * (1 + transport * near) * e_near / (near * near * near) -
                                                        mirrored * (1 + transport * far) * e_far / (far * far * far));
        const double correction = 1 - elementary::exp(-2 * extinction * (near + z));
        sum += correction * reduced_albedo * reduced_albedo * (fluence * of_fluence + irradiance * of_irradiance);
    }
    return sum / beam_samples;
}

/// Radiant exitance at distance r by light scattered once, beyond the region of total internal reflection.
double HalfSpace::single(double r) const {
    const double first = r * std::sqrt(std::max(eta * eta - 1, 0.0));
    double sum = 0;
    for (int i = 0; i < beam_samples; ++i) {
        const double z = first - elementary::log(1 - (i + 0.5) / beam_samples);
        const double d = std::sqrt(r * r + z * z), cosine = z / d;
        const double base = 1 + g * g + 2 * g * cosine;
        const double phase = quarter_pi_inverse * (1 - g * g) / (base * std::sqrt(base));
        sum +=
            albedo * elementary::exp(-(d + first)) / (d * d) * phase * (1 - leaving_reflectance(cosine, eta)) * cosine;
    }
    return sum / beam_samples;
}

/// 2 pi times the integral of both exitances times r, by the trapezoidal rule in log r.
double HalfSpace::reflectance() const {
    constexpr int radii = 96;
    constexpr double lowest = -8.0, highest = 6.5;  // 3e-4 to 660 mean free paths
    double sum = 0;
    for (int i = 0; i < radii; ++i) {
        const double r = elementary::exp(lowest + (highest - lowest) * i / (radii - 1));
        sum += (multiple(r) + single(r)) * r * r;
    }
    return sum * 2 * std::numbers::pi * (highest - lowest) / (radii - 1);
}

}  // namespace

Rgb scattering_albedo_of_reflectance(const Rgb& reflectance, double eta, double g) {
    HalfSpace medium{0, g, eta, fresnel_moment(1, eta), fresnel_moment(2, eta)};
    const auto sent_back = [&](double albedo) {
        medium.albedo = albedo;
        return medium.reflectance();
    };
    const double most = sent_back(1);
    Rgb result;
    for (int c = 0; c < 3; ++c) {
        const auto wanted = static_cast<double>(reflectance[c]);
        double low = 0, high = 1;
        if (wanted >= most) low = 1;
        for (int halving = 0; halving < 24 && wanted > 0 && low < 1; ++halving) {
            const double middle = (low + high) / 2;
            (sent_back(middle) < wanted ? low : high) = middle;
        }
        result[c] = static_cast<Real>(low);
    }
    return result;
}

}  // namespace raylex::transport
