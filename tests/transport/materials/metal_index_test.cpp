// Metals in RGB have the colours of their spectral reflectance.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>

#include "transport/color/spectrum.h"
#include "transport/materials/metal_index.h"
#include "transport/math/fresnel.h"

using namespace raylex;
using namespace raylex::transport;

namespace {

Rgb mean(const std::string& name) {
    const Result<Rgb> resolved = resolve_named_spectrum(name, SpectrumRole::unbounded, {});
    REQUIRE(resolved.ok());
    return *resolved;
}

}  // namespace

TEST_CASE("named metals reflect white light in the colour of their spectra, from above and aslant", "[materials]") {
    for (const char* metal : {"Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"}) {
        VisibleSpectrum eta{}, k{};
        const std::string name = std::string("metal-") + metal;
        REQUIRE(find_named_spectrum(name + "-eta", eta));
        REQUIRE(find_named_spectrum(name + "-k", k));
        for (const Real outside : {Real(1), Real(1.5)}) {
            const MetalIndex means{mean(name + "-eta"), mean(name + "-k")};
            const MetalIndex index = rgb_index_of_metal(eta, k, means, outside, {});
            for (const double cosine : {1.0, 0.7, 0.4, 0.15}) {
                VisibleSpectrum reflected{};
                for (std::size_t w = 0; w < visible_samples; ++w)
                    reflected[w] = fresnel_conductor(cosine, eta[w] / double{outside}, k[w] / double{outside});
                const RgbD spectral = reflectance_color(reflected, {});
                const Rgb found =
                    fresnel_conductor(static_cast<Real>(cosine), index.eta * (1 / outside), index.k * (1 / outside));
                for (int c = 0; c < 3; ++c) {
                    const double wanted = std::clamp(spectral[c], 0.0, 1.0);
                    CAPTURE(name, outside, cosine, c, wanted, found[c]);
                    // The fit's own error, measured: gold's red is 1 from above and below 1 aslant, which no index is.
                    CHECK(std::abs(static_cast<double>(found[c]) - wanted) < 0.01);
                }
            }
        }
    }
}

TEST_CASE("a metal of one index in all wavelengths keeps it", "[materials]") {
    VisibleSpectrum eta{}, k{};
    eta.fill(0.3);
    k.fill(2.5);
    const MetalIndex index = rgb_index_of_metal(eta, k, {Rgb(0.5f), Rgb(3)}, 1, {});
    for (int c = 0; c < 3; ++c) {  // a fit that is exact; floats
        CHECK(index.eta[c] == Approx(0.3).epsilon(1e-4));
        CHECK(index.k[c] == Approx(2.5).epsilon(1e-4));
    }
}
