// Microfacets and interfaces at extreme roughness, index and angle.
#include "tests/stability/probes/draws.h"
#include "tests/stability/probes/probes.h"
#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/dielectric.h"
#include "transport/materials/bsdf/facet_albedo.h"

namespace raylex::experiments {
namespace {

using transport::Ggx;
using transport::Real;
using transport::Sides;
using transport::TransportMode;
using transport::Vec3;

Vec3 at_cosine(double mu) {
    return {static_cast<Real>(std::sqrt(std::max(0.0, (1 - mu) * (1 + mu)))), 0, static_cast<Real>(mu)};
}

Ggx requested_facets(const ProbeInput& input) {
    const double alpha = input.number("alpha");
    return Ggx::from_alpha(static_cast<Real>(alpha), static_cast<Real>(input.number("alpha_y", alpha)));
}

/// Integrates D cos over normals, in slopes (p, q) = alpha r (cos phi, sin phi), dm = ax ay m.z^3 r dr dphi. The
/// density is in Real, everything else in double.
Result<ProbeResult> ggx_normalisation(const ProbeInput& input) {
    const Ggx facets = requested_facets(input);
    if (Status given = input.status(); !given) return given.error();
    ProbeResult result;
    result.expected = 1;
    result.note = facets.smooth() ? "smooth: a delta" : "";
    result.measured = 1;
    if (facets.smooth()) return result;
    constexpr int n = 400;
    const double ax = facets.alpha_x, ay = facets.alpha_y;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double psi = (i + 0.5) / n * exact_pi / 2, r = std::tan(psi),
                     dr = exact_pi / 2 / n / (std::cos(psi) * std::cos(psi));
        for (int j = 0; j < n; ++j) {
            const double phi = 2 * exact_pi * (j + 0.5) / n, x = ax * r * std::cos(phi), y = ay * r * std::sin(phi);
            const double z = 1 / std::sqrt(1 + x * x + y * y);
            const Vec3 m{static_cast<Real>(x * z), static_cast<Real>(y * z), static_cast<Real>(z)};
            sum += double(facets.d(m)) * z * ax * ay * z * z * z * r * dr * 2 * exact_pi / n;
        }
    }
    result.measured = sum;
    return result;
}

/// Returns the reflectance of slightly rough metal relative to a mirror.
Result<ProbeResult> ggx_smooth_limit(const ProbeInput& input) {
    const Vec3 wo = at_cosine(input.number("mu"));
    const Ggx facets = requested_facets(input);
    if (Status given = input.status(); !given) return given.error();
    const transport::ConductorClosure rough{facets, {0.2f, 0.92f, 1.1f}, {3.9f, 2.4f, 2.2f}, false};
    const transport::ConductorClosure mirror{{0, 0}, rough.eta, rough.k, false};
    const double reflectance = mirror.draw(wo, {}).weight.average();
    Draws draws(41);
    RunningMean mean;
    for (int i = 0; i < 20'000; ++i) {
        const transport::LocalSample s = rough.draw(wo, draws.two());
        mean.add(s.pdf > 0 ? double(s.weight.average()) / reflectance : 0);
    }
    ProbeResult result;
    result.measured = mean.mean();
    result.standard_error = mean.standard_error();
    result.expected = 1;
    return result;
}

/// Returns the cosine that is `steps` units of Real away from the critical angle inside glass.
Real cosine_near_critical(double eta, double steps) {
    const double outwards = 1 / static_cast<Real>(eta);  // as rounded to Real
    Real cosine = static_cast<Real>(std::sqrt(1 - outwards * outwards));
    for (int i = 0; i < std::abs(steps); ++i) cosine = std::nextafter(cosine, steps > 0 ? Real(1) : Real(0));
    return cosine;
}

Result<ProbeResult> critical_energy(const ProbeInput& input) {
    const double eta = input.number("eta"), steps = input.number("ulps");
    if (Status given = input.status(); !given) return given.error();
    const transport::DielectricClosure glass{{0, 0}, static_cast<Real>(eta)};
    Vec3 wo = at_cosine(double(cosine_near_critical(eta, steps)));
    wo.z = -cosine_near_critical(eta, steps);
    double total = 0;
    for (const Sides side : {Sides::reflection, Sides::transmission}) {
        const auto s = glass.draw(wo, Real(0.5), {Real(0.5), Real(0.5)}, TransportMode::importance, side);
        if (s.pdf > 0) total += double(s.weight.r) * double(s.pdf);
    }
    ProbeResult result;
    result.measured = total;
    result.expected = 1;
    result.ulp = 0x1p-24;
    return result;
}

/// Counts the steps at which reflectance falls as the angle grows, within `ulps` steps of the critical angle.
Result<ProbeResult> critical_monotone(const ProbeInput& input) {
    const double eta = input.number("eta"), steps = input.number("ulps", 64);
    if (Status given = input.status(); !given) return given.error();
    ProbeResult result;
    Real before = 0;
    for (double k = steps; k >= -steps; --k) {
        const Real f = transport::fresnel_dielectric(cosine_near_critical(eta, k), 1 / static_cast<Real>(eta));
        result.measured += !(f >= before && f <= 1);
        before = f;
    }
    result.measured += before != 1;
    result.expected = 0;
    return result;
}

/// Compares the reflectance of a dielectric or conductor with the same formula in complex double.
Result<ProbeResult> interface_reflectance(const ProbeInput& input) {
    const double mu = input.number("mu"), n = input.number("eta"), k = input.number("k", 0);
    if (Status given = input.status(); !given) return given.error();
    const Real c = static_cast<Real>(mu), eta = static_cast<Real>(n), kr = static_cast<Real>(k);
    ProbeResult result;
    result.measured = k > 0 ? transport::fresnel_conductor(c, eta, kr) : transport::fresnel_dielectric(c, eta);
    // (n + ik)^2 - sin^2 = (a + ib)^2: Born and Wolf, 14.2, in double.
    const double cd = c, nd = eta, kd = kr, sin2 = (1 - cd) * (1 + cd), re = nd * nd - kd * kd - sin2, im = 2 * nd * kd;
    const double size = std::hypot(re, im), a = std::sqrt(std::max(0.0, (size + re) / 2)),
                 b = std::sqrt(std::max(0.0, (size - re) / 2));
    const double across = (std::pow(cd - a, 2) + b * b) / (std::pow(cd + a, 2) + b * b);
    const double slope = sin2 / cd;
    const double along = across * (std::pow(a - slope, 2) + b * b) / (std::pow(a + slope, 2) + b * b);
    result.expected = (across + along) / 2;
    return result;
}

/// Compares the table of facet albedos with their integral by many more points.
Result<ProbeResult> albedo_table(const ProbeInput& input) {
    const double eta = input.number("eta", 0), mu = input.number("mu");
    const Ggx facets = requested_facets(input);
    if (Status given = input.status(); !given) return given.error();
    Vec3 wo = at_cosine(std::abs(mu));
    const Real from_there = static_cast<Real>(eta > 0 && mu < 0 ? 1 / eta : eta);
    ProbeResult result;
    result.expected = transport::FacetAlbedo::integrate(facets, wo, from_there, 262144);
    wo.z = std::copysign(wo.z, static_cast<Real>(mu));
    result.measured = (*transport::FacetAlbedo::shared({}, static_cast<Real>(eta)))(facets, wo);
    return result;
}

}  // namespace

std::span<const NamedProbe> facet_probes() {
    static constexpr NamedProbe table[] = {
        {"ggx_normalisation", "integral of D cos over normals; alpha, alpha_y", ggx_normalisation},
        {"ggx_smooth_limit", "reflectance of metal with this roughness relative to its mirror; alpha, mu",
         ggx_smooth_limit},
        {"critical_energy", "R + T of ideal glass from inside, `ulps` steps from the critical cosine; eta, ulps",
         critical_energy},
        {"critical_monotone", "number of steps around the critical angle at which reflectance falls; eta, ulps (64)",
         critical_monotone},
        {"fresnel", "reflectance of an interface, compared with double; mu, eta, k (0: dielectric)",
         interface_reflectance},
        {"facet_albedo", "table of facet albedos, compared with its integral; alpha, mu, eta (0: metal)",
         albedo_table}};
    return table;
}

}  // namespace raylex::experiments
