// GGX, metal and glass against quadrature and the literature's identities (stability rows 11, 13 to 18).
#include <catch2/catch.hpp>

#include <complex>
#include <numbers>

#include "tests/transport/materials_support.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

/// Integral of g over normals of the upper hemisphere, in slopes of the facets: m ~ (-ax p, -ay q, 1), dm = ax ay m.z^3
/// dp dq. p, q in polar form with radius r = tan(psi), so that the whole plane is a finite rectangle.
template <class F>
double integrate_normals(const Ggx& facets, const F& g, int n) {
    double sum = 0;
    const double half_pi = std::numbers::pi / 2;
    for (int i = 0; i < n; ++i) {
        const double psi = (i + 0.5) / n * half_pi, r = std::tan(psi),
                     dr = half_pi / n / (std::cos(psi) * std::cos(psi));
        for (int j = 0; j < n; ++j) {
            const double phi = 2 * std::numbers::pi * (j + 0.5) / n;
            const double x = facets.alpha_x * r * std::cos(phi), y = facets.alpha_y * r * std::sin(phi);
            const double z = 1 / std::sqrt(1 + x * x + y * y);
            const Vec3 m{static_cast<float>(x * z), static_cast<float>(y * z), static_cast<float>(z)};
            sum += g(m) * facets.alpha_x * facets.alpha_y * z * z * z * r * dr * 2 * std::numbers::pi / n;
        }
    }
    return sum;
}

DielectricClosure smooth_glass(float eta) {
    return {Ggx::from_alpha(0, 0), eta};
}

/// R + T of basic radiance, both branches of the ideal interface.
double smooth_glass_total(float cosine, float eta) {
    const DielectricClosure glass = smooth_glass(eta);
    const Vec3 wo = local_direction(cosine);
    double total = 0;
    for (const Sides side : {Sides::reflection, Sides::transmission}) {
        const LocalSample s = glass.draw(wo, 0.5f, {0.5f, 0.5f}, TransportMode::importance, side);
        if (s.pdf > 0) total += static_cast<double>(s.weight.r) * s.pdf;
    }
    return total;
}

}  // namespace

TEST_CASE("the density of normals at the pole keeps its digits") {
    // The value at the pole, where the usual tan^2 form cancels: 1 / (pi alpha^2).
    for (const float alpha : {1e-4f, 1e-3f, 1e-2f})
        CHECK(Ggx{alpha, alpha}.d({0, 0, 1}) == Approx(1 / (std::numbers::pi * alpha * alpha)).epsilon(1e-5));
}

TEST_CASE("visible normals project onto the area seen: Smith's masking is consistent with the distribution") {
    for (const float alpha : {0.05f, 0.3f, 1.0f})
        for (const float cosine : {1.0f, 0.6f, 0.2f}) {
            const Ggx facets{alpha, 0.5f * alpha};
            const Vec3 w = local_direction(cosine);
            const double visible = integrate_normals(
                facets,
                [&](const Vec3& m) {
                    return static_cast<double>(facets.g1(w)) * facets.d(m) * std::max(0.0f, dot(w, m));
                },
                600);
            INFO("alpha " << alpha << ", cos " << cosine);
            CHECK(visible == Approx(cosine).epsilon(2e-4));  // Heitz 2014, (16)
        }
}

TEST_CASE("normals seen from above follow the distribution, a thin strip of them included") {
    // In slopes over alpha the density is 1 / (pi (1 + r^2)^2): r^2 / (1 + r^2) and the angle are uniform.
    const float pairs[][2] = {{0.3f, 0}, {1e-3f, 1e-3f}, {1, 0.05f}, {1, 1}};
    const double level = 1 - std::pow(1 - 0.01, 1.0 / std::size(pairs));  // Sidak
    Random random(8);
    for (const auto& pair : pairs) {
        const Ggx facets = Ggx::from_alpha(pair[0], pair[1]);
        constexpr int rings = 10, sectors = 10, draws = 100'000;
        std::vector<double> count(rings * sectors);
        for (int i = 0; i < draws; ++i) {
            const Vec3 m = facets.sample_visible_normal({0, 0, 1}, random.two());
            const double p = m.x / m.z / facets.alpha_x, q = m.y / m.z / facets.alpha_y, r2 = p * p + q * q;
            const double angle = std::atan2(q, p) / (2 * std::numbers::pi) + 0.5;
            const int ring = std::min(static_cast<int>(r2 / (1 + r2) * rings), rings - 1);
            count[static_cast<std::size_t>(ring * sectors +
                                           std::min(static_cast<int>(angle * sectors), sectors - 1))] += 1;
        }
        double chi2 = 0;
        const double expected = static_cast<double>(draws) / (rings * sectors);
        for (const double c : count) chi2 += (c - expected) * (c - expected) / expected;
        INFO("alpha " << pair[0] << " x " << pair[1]);
        CHECK(chi_square_tail(chi2, rings * sectors - 1) > level);
    }
}

TEST_CASE("conductor reflectance agrees with the complex Fresnel equations") {
    for (const double cosine : {1.0, 0.7, 0.2, 1e-3})
        for (const double eta : {0.2, 1.0, 2.5})
            for (const double k : {0.0, 1.0, 3.9}) {
                const std::complex<double> index(eta, -k),
                    cos_t = std::sqrt(1.0 - (1 - cosine * cosine) / (index * index));
                const auto parallel = (index * cosine - cos_t) / (index * cosine + cos_t);
                const auto perpendicular = (cosine - index * cos_t) / (cosine + index * cos_t);
                const double expected = (std::norm(parallel) + std::norm(perpendicular)) / 2;
                INFO(cosine << " " << eta << " " << k);
                // eta^2 - k^2 - sin^2 cancels for a real index near grazing: a root of one ulp remains, divided by cos.
                CHECK(fresnel_conductor(static_cast<float>(cosine), static_cast<float>(eta), static_cast<float>(k)) ==
                      Approx(expected).margin(3e-5));
            }
    CHECK(fresnel_conductor(Real(1), Real(1), conductor_k_from_reflectance(0.7f)) == Approx(0.7).epsilon(1e-5));
    CHECK(fresnel_dielectric(1, 1.5f) == Approx(0.04).epsilon(1e-5));
    for (const float huge : {1e6f, 9e8f, 1.1e9f, 1e19f, 3e38f})  // no power of them is a float
        for (const auto& [eta, k] : {std::pair(huge, 1.0f), std::pair(1.0f, huge), std::pair(huge, huge)})
            for (const float cosine : {1.0f, 0.3f, 0.01f}) {
                CAPTURE(eta, k, cosine);
                CHECK(fresnel_conductor(cosine, eta, k) == Approx(1).margin(5e-4));
            }
}

TEST_CASE("ideal glass reflects and transmits everything, on both sides and at every angle") {
    for (const float eta : {1.5f, 1 / 1.5f, 1.0f, 2.4f})
        for (float cosine = 0.001f; cosine < 1; cosine += 0.0137f)
            for (const float side : {1.0f, -1.0f}) {
                INFO("eta " << eta << ", cos " << side * cosine);
                CHECK(smooth_glass_total(side * cosine, eta) == Approx(1).epsilon(2 * 0x1p-23));
            }
}

TEST_CASE("refraction follows Snell, radiance is scaled by the squared index and back") {
    const DielectricClosure glass = smooth_glass(1.5f);
    const Vec3 wo = local_direction(0.4f);
    const LocalSample in = glass.draw(wo, 0.9f, {0.5f, 0.5f}, TransportMode::radiance, Sides::transmission);
    REQUIRE(in.transmitted);
    CHECK(in.eta == 1.5f);
    CHECK(std::hypot(in.wi.x, in.wi.y) * 1.5f == Approx(std::hypot(wo.x, wo.y)).epsilon(1e-6));
    CHECK(in.wi.z < 0);
    const LocalSample out = glass.draw(-in.wi, 0.9f, {0.5f, 0.5f}, TransportMode::radiance, Sides::transmission);
    // Leaving where it entered from: the same interface seen from inside.
    const LocalSample back = glass.draw(in.wi, 0.9f, {0.5f, 0.5f}, TransportMode::radiance, Sides::transmission);
    REQUIRE(back.transmitted);
    CHECK(length(back.wi - Vec3{-in.wi.x * 1.5f, -in.wi.y * 1.5f, 0.4f}) < 1e-5f);
    CHECK(in.weight.r * back.weight.r == Approx(square(1 - fresnel_dielectric(0.4f, 1.5f))).epsilon(1e-5));
    CHECK(out.pdf > 0);
}

TEST_CASE("a thin pane adds up all its inner reflections and bends nothing") {
    Bsdf pane;
    pane.set(tilted_frame(), ThinDielectricClosure{1.5f});
    CHECK_FALSE(pane.has_density());
    for (const float cosine : {1.0f, 0.3f, -0.5f}) {
        const float f = fresnel_dielectric(std::abs(cosine), 1.5f);
        float series = f, inner = (1 - f) * (1 - f) * f;  // F + T F T + T F F F T + ...
        for (int i = 0; i < 200; ++i, inner *= f * f) series += inner;
        const Vec3 wo = tilted_frame().to_world(local_direction(cosine));
        const BsdfSample reflected = pane.sample(wo, 0, {0.5f, 0.5f}),
                         through = pane.sample(wo, one_minus_epsilon, {0.5f, 0.5f});
        CHECK(reflected.pdf == Approx(series).epsilon(1e-5));
        CHECK(reflected.pdf + through.pdf == Approx(1).epsilon(1e-6));
        CHECK((!reflected.transmitted && through.transmitted && through.eta == 1));
        CHECK(through.weight == Rgb(1));
        CHECK(length(through.wi + wo) < 1e-6f);
    }
}

TEST_CASE("anisotropic facets stretch along dpdu's direction, whatever the frame") {
    const Frame frame = tilted_frame();
    Bsdf metal;
    metal.set(frame, ConductorClosure{Ggx::from_alpha(0.5f, 0.05f), Rgb(1), Rgb(0), true});
    const Vec3 wo = frame.n;
    const auto at = [&](const Vec3& tangent) {
        return metal.evaluate(wo, normalize(frame.n + tangent * 0.4f)).value.r;
    };
    CHECK(at(frame.s) > 50 * at(frame.t));
    CHECK(at(frame.s) == Approx(at(-frame.s)).epsilon(1e-4));
}
