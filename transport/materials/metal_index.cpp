#include "transport/materials/metal_index.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "display/services/elementary.h"
#include "transport/color/spectrum.h"
#include "transport/math/fresnel.h"

namespace raylex::transport {
namespace {

/// Gauss-Legendre quadrature on [0, 1].
constexpr std::array<double, 8> cosines{0.0198550717512319, 0.1016667612931866, 0.2372337950418355, 0.4082826787521751,
                                        0.5917173212478249, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681},
    weights{0.0506142681451881, 0.1111905172266872, 0.1568533229389436, 0.1813418916891810,
            0.1813418916891810, 0.1568533229389436, 0.1111905172266872, 0.0506142681451881};
using Reflectances = std::array<double, cosines.size()>;

/// Logarithms of eta and k: both stay positive.
struct Index {
    double eta, k;

    [[nodiscard]] double reflectance(double cosine) const {
        return fresnel_conductor(cosine, elementary::exp(eta), elementary::exp(k));
    }
};

double squared_error(const Index& index, const Reflectances& wanted) {
    double sum = 0;
    for (std::size_t i = 0; i < cosines.size(); ++i) {
        const double off = index.reflectance(cosines[i]) - wanted[i];
        sum += weights[i] * cosines[i] * off * off;
    }
    return sum;
}

/// A Levenberg-Marquardt step from `at`, with derivatives from differences.
Index step_from(const Index& at, const Reflectances& wanted, double damping) {
    constexpr double h = 1e-5;
    double a = 0, b = 0, c = 0, u = 0, v = 0;
    for (std::size_t i = 0; i < cosines.size(); ++i) {
        const double weight = weights[i] * cosines[i], here = at.reflectance(cosines[i]);
        const double by_eta = (Index{at.eta + h, at.k}.reflectance(cosines[i]) - here) / h,
                     by_k = (Index{at.eta, at.k + h}.reflectance(cosines[i]) - here) / h;
        a += weight * by_eta * by_eta;
        b += weight * by_eta * by_k;
        c += weight * by_k * by_k;
        u += weight * by_eta * (wanted[i] - here);
        v += weight * by_k * (wanted[i] - here);
    }
    a *= 1 + damping;
    c *= 1 + damping;
    const double determinant = a * c - b * b;
    if (!(determinant > 0)) return at;
    const auto bounded = [](double step) { return std::clamp(step, -1.0, 1.0); };
    return {at.eta + bounded((c * u - b * v) / determinant), at.k + bounded((a * v - b * u) / determinant)};
}

Index fit(Index at, const Reflectances& wanted) {
    double error = squared_error(at, wanted), damping = 1e-2;
    for (int round = 0; round < 100; ++round) {
        const Index next = step_from(at, wanted, damping);
        // Squares of larger ones exceed a float; metals are far below.
        if (!(std::max(std::abs(next.eta), std::abs(next.k)) < 10)) break;
        if (const double now = squared_error(next, wanted); now < error) {
            at = next;
            error = now;
            damping *= 0.3;
        } else {
            damping *= 4;
        }
    }
    return at;
}

}  // namespace

MetalIndex rgb_index_of_metal(const VisibleSpectrum& eta, const VisibleSpectrum& k, const MetalIndex& means,
                              Real outside, const ColorContext& context) {
    std::array<Reflectances, 3> wanted{};
    for (std::size_t i = 0; i < cosines.size(); ++i) {
        VisibleSpectrum reflected{};
        for (std::size_t w = 0; w < visible_samples; ++w)
            reflected[w] = fresnel_conductor(cosines[i], eta[w] / double{outside}, k[w] / double{outside});
        const RgbD seen = reflectance_color(reflected, context);
        for (int c = 0; c < 3; ++c) wanted[static_cast<std::size_t>(c)][i] = std::clamp(seen[c], 0.0, 1.0);
    }
    MetalIndex result;
    for (int c = 0; c < 3; ++c) {
        // The means are near the solution; a k of 0 has no logarithm.
        const Index begin{elementary::log(std::max(double{means.eta[c]} / double{outside}, 1e-2)),
                          elementary::log(std::max(double{means.k[c]} / double{outside}, 1e-2))};
        const Index found = fit(begin, wanted[static_cast<std::size_t>(c)]);
        result.eta[c] = static_cast<Real>(elementary::exp(found.eta)) * outside;
        result.k[c] = static_cast<Real>(elementary::exp(found.k)) * outside;
    }
    return result;
}

}  // namespace raylex::transport
