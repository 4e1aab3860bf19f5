// The Henyey-Greenstein phase function at extreme asymmetry.
#include <cmath>

#include "tests/stability/probes/probes.h"
#include "transport/media/phase.h"

namespace raylex::experiments {
namespace {

using transport::Real;
using transport::Vec2;
using transport::Vec3;

/// Returns 1 - cos theta of the sample for `u`, in double, by the inversion of Henyey and Greenstein's distribution in
/// a form without cancellation for any g in [0, 1).
double reference(double g, double u) {
    const double denominator = (1 - g) + 2 * g * (1 - u);
    return 2 * (1 - g) * (1 - g) * u * (1 + g - g * u) / (denominator * denominator);
}

/// Returns the mean of 1 - cos over a lattice of points; the last point is the largest number below 1. All terms are
/// positive, so no error can cancel.
Result<ProbeResult> mean_cosine(const ProbeInput& input) {
    const auto g = static_cast<Real>(input.number("g"));
    const auto samples = static_cast<std::uint64_t>(input.number("samples", 65536));
    const Vec3 forward{0, 0, 1};
    double sum = 0, expected = 0;
    for (std::uint64_t i = 0; i < samples; ++i) {
        const float u = i + 1 == samples ? 1 - 0x1p-24f : static_cast<float>(double(i) / double(samples));
        // 1 - cos without cancellation, because near g = 1 the cosine has no digits left.
        const Vec3 axis = g < 0 ? -forward : forward;
        const Vec3 wi = transport::sample_phase(g, forward, Vec2{u, Real(0.5)}).wi;
        sum += 0.5 * double(transport::length_squared(wi - axis));
        expected += reference(std::abs(double(g)), u);
    }
    ProbeResult result;
    result.measured = sum / double(samples);
    result.expected = expected / double(samples);
    return result;
}

}  // namespace

std::span<const NamedProbe> phase_probes() {
    static constexpr NamedProbe table[] = {
        {"phase_mean_cosine",
         "mean of 1 - cos theta of Henyey-Greenstein samples, with theta from the axis of sign g; g, samples",
         mean_cosine}};
    return table;
}

}  // namespace raylex::experiments
