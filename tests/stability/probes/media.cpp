// Flights through media of any optical depth, and the integral of the phase function.
#include "transport/media/medium.h"

#include "tests/stability/probes/draws.h"
#include "tests/stability/probes/probes.h"
#include "transport/media/phase.h"

namespace raylex::experiments {
namespace {

using transport::Medium;
using transport::Real;
using transport::Rgb;
using transport::Vec2;

/// A slab with the numbers "tau" (of green), "albedo" (1), "red" and "blue" (factors of the other colours' extinction,
/// 1), and "length" (1).
struct Slab {
    Medium medium;
    double length, sigma[3];
    double albedo;

    explicit Slab(const ProbeInput& input)
        : length(input.number("length", 1)),
          sigma{input.number("tau") / length * input.number("red", 1), input.number("tau") / length,
                input.number("tau") / length * input.number("blue", 1)},
          albedo(input.number("albedo", 1)) {
        medium.sigma_t = Rgb(static_cast<Real>(sigma[0]), static_cast<Real>(sigma[1]), static_cast<Real>(sigma[2]));
        medium.sigma_s = medium.sigma_t * static_cast<Real>(albedo);
        medium.sigma_a = medium.sigma_t - medium.sigma_s;
        medium.grey = sigma[0] == sigma[1] && sigma[1] == sigma[2];
        medium.scatters = albedo > 0;
    }
};

/// Maps one number v of 48 bits to the unit square, so that v orders the outcomes of flights.
Vec2 unit_square(double v) {
    const double high = std::floor(v * 0x1p24);
    return {static_cast<Real>(std::floor((v * 0x1p24 - high) * 0x1p24) * 0x1p-24), static_cast<Real>(high * 0x1p-24)};
}

/// Returns the mean weight of green of flights that collide, or that pass. Collisions have small v; the first fraction
/// `dense` of the interval is sampled as finely as the rest.
ProbeResult mean_flight(const ProbeInput& input, bool collided) {
    const Slab slab(input);
    const int n = static_cast<int>(input.number("samples", 1048576));
    const double tau = slab.sigma[1] * slab.length, dense = std::clamp(2 * std::max(tau, 0x1p-16), 0x1p-15, 0.5);
    double sum = 0;
    RunningMean error;
    Draws draws(3);
    for (int part = 0; part < 16; ++part) {
        const double shift = draws.fine();
        double here = 0;
        for (int i = 0; i < n / 16; ++i) {
            const double at = (i + shift) / (n / 16);
            for (const double v : {at * dense, dense + at * (1 - dense)}) {
                // Coloured media choose a colour by u.x; uses the middle of each colour in turn.
                for (int colour = 0; colour < (slab.medium.grey ? 1 : 3); ++colour) {
                    Vec2 u = unit_square(v);
                    if (!slab.medium.grey) u.x = (static_cast<Real>(colour) + u.x) / 3;
                    const auto f =
                        transport::sample_free_flight(slab.medium, Rgb(1), static_cast<Real>(slab.length), u);
                    if (f.collided == collided)
                        here += double(f.weight.g) * (v < dense ? dense : 1 - dense) / (slab.medium.grey ? 1 : 3);
                }
            }
        }
        error.add(here / (n / 16));
        sum += here / (n / 16) / 16;
    }
    ProbeResult result;
    result.measured = sum;
    result.standard_error = error.standard_error();
    result.degrees = 15;
    return result;
}

Result<ProbeResult> flight_scattered(const ProbeInput& input) {
    ProbeResult result = mean_flight(input, true);
    if (Status given = input.status(); !given) return given.error();
    result.expected = -std::expm1(-input.number("tau")) * input.number("albedo", 1);
    return result;
}

Result<ProbeResult> flight_passed(const ProbeInput& input) {
    ProbeResult result = mean_flight(input, false);
    if (Status given = input.status(); !given) return given.error();
    result.expected = std::exp(-input.number("tau"));
    return result;
}

/// Returns the optical depth that the last pair of numbers reaches.
Result<ProbeResult> flight_deepest(const ProbeInput&) {
    Medium medium;
    medium.sigma_t = medium.sigma_s = Rgb(1);
    const Real last = transport::one_minus_epsilon;
    ProbeResult result;
    result.measured =
        transport::sample_free_flight(medium, Rgb(1), std::numeric_limits<Real>::infinity(), {last, last}).distance;
    result.expected = transport::real_is_double ? -std::log(std::pow(2.0, -53)) : 48 * std::log(2.0);
    return result;
}

Result<ProbeResult> medium_glow(const ProbeInput& input) {
    Slab slab(input);
    if (Status given = input.status(); !given) return given.error();
    slab.medium.emission = slab.medium.sigma_t;
    slab.medium.emits = true;
    ProbeResult result;
    result.measured = transport::emission_along(slab.medium, static_cast<Real>(slab.length)).g;
    result.expected = -std::expm1(-double(slab.medium.sigma_t.g) * slab.length);
    return result;
}

/// Integrates the phase function over directions, in h = 1 - cos around its axis: h = w (1 / s^2 - 1), with w of the
/// size of the lobe, because beyond it the density falls with h^(-3/2).
Result<ProbeResult> phase_integral(const ProbeInput& input) {
    const auto g = static_cast<Real>(input.number("g"));
    if (Status given = input.status(); !given) return given.error();
    const double a = std::abs(double(g)), w = (1 - a) * (1 - a) + 1e-30, least = 1 / std::sqrt(1 + 2 / w);
    constexpr int n = 20000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double s = least + (1 - least) * (i + 0.5) / n, h = w * (1 / (s * s) - 1);
        sum += 2 * exact_pi * double(transport::phase_detail::value(std::abs(g), static_cast<Real>(h))) * 2 * w /
               (s * s * s) * (1 - least) / n;
    }
    ProbeResult result;
    result.measured = sum;
    result.expected = 1;
    return result;
}

}  // namespace

std::span<const NamedProbe> media_probes() {
    static constexpr NamedProbe table[] = {
        {"flight_scattered", "mean weight of flights that collide in a slab; tau, albedo, red, blue, length, samples",
         flight_scattered},
        {"flight_passed", "mean weight of flights that pass a slab; tau, albedo, red, blue, length, samples",
         flight_passed},
        {"flight_deepest", "optical depth reached by the largest random numbers", flight_deepest},
        {"medium_glow", "radiance of a slab that emits as a black body of radiance 1; tau, length", medium_glow},
        {"phase_integral", "integral of Henyey-Greenstein's phase function; g", phase_integral}};
    return table;
}

}  // namespace raylex::experiments
