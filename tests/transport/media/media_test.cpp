// Media without rendering: the phase function, flights through coloured fog, emission along a segment.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <numbers>

#include "transport/geometry/ray.h"
#include "transport/math/sampling.h"
#include "transport/media/medium.h"
#include "transport/media/phase.h"

using namespace raylex;
using namespace raylex::transport;

namespace {

Medium fog(const Rgb& sigma_a, const Rgb& sigma_s) {
    Medium m;
    m.sigma_a = sigma_a;
    m.sigma_s = sigma_s;
    m.sigma_t = sigma_a + sigma_s;
    m.grey = m.sigma_t.r == m.sigma_t.g && m.sigma_t.g == m.sigma_t.b;
    m.scatters = !sigma_s.is_black();
    return m;
}

}  // namespace

TEST_CASE("the phase function is normalised, has mean cosine g, and sampling draws from it", "[media]") {
    for (const float g : {0.0f, 1e-6f, 1e-3f, 0.3f, -0.3f, 0.9f, -0.9f, 0.999f, 1 - 0x1p-20f, -(1 - 0x1p-24f)}) {
        CAPTURE(g);
        // The inversion formula against its own density. By the substitution rule the density at quantile u is du / (2
        // pi dh), so the differences of h over a fine grid of u must give the pdf at the middle.
        const Vec3 forward = normalize(Vec3{0.3f, -0.5f, 0.8f});
        double cosine = 0;
        constexpr int n = 4096;
        for (int i = 0; i < n; ++i) {
            const float u = (float(i) + 0.5f) / n;
            const PhaseSample s = sample_phase(g, forward, {u, 0.37f});
            REQUIRE(is_finite(s.wi));
            REQUIRE(s.pdf > 0);
            CHECK(std::abs(length(s.wi) - 1) <= 1e-6f);
            cosine += double(dot(s.wi, forward)) / n;
            // If the lobe is narrow, the rounded direction has lost the precision of h: 1 - |g| is the lobe's width.
            if (std::abs(g) < 0.99f) CHECK(phase_pdf(g, forward, s.wi) == Approx(s.pdf).epsilon(2e-5));
        }
        CHECK(std::abs(cosine - double(g)) <= 3e-4);  // midpoint rule over u: O(1/n) where the lobe's tail is steep
        for (const float u : {0.0f, 0x1p-32f, one_minus_epsilon}) {
            const PhaseSample s = sample_phase(g, forward, {u, u});
            CHECK(is_finite(s.wi));
            CHECK(std::isfinite(s.pdf));
            CHECK(s.pdf > 0);
        }
    }
    for (const float g : {0.0f, 0.3f, -0.7f, 0.95f}) {
        double integral = 0, mean = 0;
        constexpr int n = 400000;      // the step is a hundredth of the lobe's width at g = 0.95
        for (int i = 0; i < n; ++i) {  // over the cosine, midpoint rule
            const double c = -1 + (i + 0.5) * 2 / n;
            const Vec3 wi{float(std::sqrt(1 - c * c)), 0, float(c)};
            const double p = double(phase_pdf(g, {0, 0, 1}, wi)) * 2 * std::numbers::pi * 2 / n;
            integral += p;
            mean += p * c;
        }
        CHECK(integral == Approx(1).epsilon(1e-5));
        CHECK(std::abs(mean - double(g)) <= 1e-5);
    }
}

TEST_CASE("flights through coloured fog are unbiased in every colour", "[media]") {
    const Medium media[] = {fog({0.1f, 0.1f, 0.1f}, {0.4f, 0.4f, 0.4f}), fog({0.05f, 0.2f, 1.0f}, {0.3f, 1.0f, 2.0f}),
                            fog({0, 0.5f, 0}, {0, 0.5f, 4}), fog({0.1f, 0.2f, 0.3f}, {0.4f, 0.3f, 0.2f})};
    const Rgb throughputs[] = {{1, 1, 1}, {0.2f, 0.5f, 1}, {1e-6f, 1, 0.3f}};
    constexpr int deep = 32768;
    for (const Medium& m : media)
        for (const Rgb& throughput : throughputs)
            for (const float end : {0.2f, 6.0f}) {
                // The choice of a colour has three outcomes, weighted with their probabilities; distances are on a
                // grid.
                RgbD through(0), scattered(0);
                const Rgb share = throughput / (throughput.r + throughput.g + throughput.b);
                const Rgb middle{share.r / 2, share.r + share.g / 2, share.r + share.g + share.b / 2};
                for (int a = 0; a < 3; ++a)
                    for (int d = 0; d < deep; ++d) {
                        const FreeFlight f =
                            sample_free_flight(m, throughput, end, {middle[a], (float(d) + 0.5f) / deep});
                        (f.collided ? scattered : through) += RgbD(f.weight) * (double(share[a]) / deep);
                    }
                for (int c = 0; c < 3; ++c) {
                    CAPTURE(c, end, m.sigma_t[c], throughput[c]);
                    const double t = std::exp(-double(m.sigma_t[c]) * double(end));
                    const double albedo = m.sigma_t[c] > 0 ? double(m.sigma_s[c] / m.sigma_t[c]) : 0;
                    // The grid is cut at `end` to half a step of 1/32768, times the largest weight, 525: that of red
                    // through the third medium, which rarely draws the distance and depends on green's exp(-6).
                    CHECK(through[c] == Approx(t).margin(0.009));
                    CHECK(scattered[c] == Approx(albedo * (1 - t)).margin(0.009));
                }
            }
}

TEST_CASE("no light is lost in thick, thin and unbounded fog", "[media]") {
    const Medium thick = fog({1e4f, 2e4f, 3e4f}, {1e4f, 1e4f, 1e4f}), thin = fog(Rgb(1e-8f), Rgb(1e-8f));
    for (const float u : {0.0f, 0.3f, one_minus_epsilon}) {
        const FreeFlight f = sample_free_flight(thick, Rgb(1), infinity, {u, u});
        CHECK(f.collided);
        CHECK(is_finite(f.weight));
        CHECK(f.weight.max() <= 3.001f);  // one colour in three may have drawn it
        CHECK(is_finite(sample_free_flight(thick, {0, 0, 1}, 1e30f, {u, u}).weight));
        CHECK(is_finite(sample_free_flight(fog(Rgb(0), {0, 1, 0}), {1, 0, 1}, infinity, {u, u}).weight));
    }
    CHECK(transmittance(thick, 1).is_black());
    CHECK(transmittance(fog(Rgb(0), {0, 1, 0}), infinity) == Rgb(1, 0, 1));
    Medium glow = thin;
    glow.emission = Rgb(3);
    CHECK(emission_along(glow, 1e-3f).r == Approx(3e-3f));  // 1 - exp(-2e-11) would be 0 in float
    glow = fog(Rgb(2), Rgb(1));
    glow.emission = Rgb(2 * 5);
    CHECK(emission_along(glow, infinity).g == Approx(10.0 / 3));
    // Absorption is sampled where light is attenuated: the mean depth of truncated exponentials.
    const Medium absorber = fog(Rgb(2), Rgb(0));
    double mean = 0;
    constexpr int n = 10000;
    for (int i = 0; i < n; ++i) mean += double(sample_absorption(absorber, 1, {0.5f, (float(i) + 0.5f) / n})) / n;
    CHECK(mean == Approx(0.5 - std::exp(-2.0) / (1 - std::exp(-2.0))).epsilon(1e-4));
}
