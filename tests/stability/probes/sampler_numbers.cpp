// Numbers of samplers at indices and dimensions beyond their tables.
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "tests/stability/probes/probes.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::experiments {
namespace {

using transport::PixelSampler;
using transport::Real;
using transport::SamplerKind;
using transport::Vec2;

Result<SamplerKind> kind_of(const ProbeInput& input) {
    const std::string name = input.word("sampler", "sobol");
    if (name == "sobol") return SamplerKind::sobol;
    if (name == "zsobol") return SamplerKind::zsobol;
    if (name == "independent") return SamplerKind::independent;
    return error_at(input.where(), "no sampler '" + name + "'; expected sobol, zsobol or independent");
}

/// Counts the distinct points in [0, 1) among `count` points from index `first`.
Result<ProbeResult> distinct_points(const ProbeInput& input) {
    auto kind = kind_of(input);
    if (!kind) return kind.error();
    const double first = input.number("first"), count = input.number("count", 5);
    const auto dimension = static_cast<std::uint32_t>(input.number("dimension", 400));
    if (Status given = input.status(); !given) return given.error();
    std::set<std::pair<Real, Real>> points;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
        const Vec2 p = PixelSampler(*kind, 0, 0, 0, static_cast<std::uint64_t>(first) + i).get_2d(dimension);
        if (p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1) points.insert({p.x, p.y});
    }
    ProbeResult result;
    result.measured = static_cast<double>(points.size());
    result.expected = count;
    return result;
}

/// Returns Pearson's statistic of pairs (one number of each of two dimensions) over an 8 x 8 grid, standardised to mean
/// 0 and deviation 1 for independent dimensions.
Result<ProbeResult> dimension_correlation(const ProbeInput& input) {
    auto kind = kind_of(input);
    if (!kind) return kind.error();
    const auto a = static_cast<std::uint32_t>(input.number("dimension")),
               b = static_cast<std::uint32_t>(input.number("other"));
    const auto first = static_cast<std::uint64_t>(input.number("first", 0)),
               samples = static_cast<std::uint64_t>(input.number("samples", 65536));
    if (Status given = input.status(); !given) return given.error();
    constexpr std::size_t bins = 8;
    std::vector<double> counts(bins * bins);
    for (std::uint64_t i = 0; i < samples; ++i) {
        // One sample from each of many pixels, because the stratification inside a pixel must not count.
        const auto x = static_cast<std::int32_t>(i % 1024), y = static_cast<std::int32_t>(i / 1024);
        const PixelSampler sampler(*kind, 0, x, y, first);
        const auto bin = [&](std::uint32_t dimension) {
            return static_cast<std::size_t>(double(sampler.get_1d(dimension)) * bins);
        };
        ++counts[bin(a) * bins + bin(b)];
    }
    const double expected = static_cast<double>(samples) / double(bins * bins), degrees = bins * bins - 1;
    double statistic = 0;
    for (const double count : counts) statistic += (count - expected) * (count - expected) / expected;
    ProbeResult result;
    result.measured = (statistic - degrees) / std::sqrt(2 * degrees);
    result.expected = 0;
    result.standard_error = 1;
    return result;
}

}  // namespace

std::span<const NamedProbe> sampler_probes() {
    static constexpr NamedProbe table[] = {
        {"sampler_distinct_points",
         "number of a sampler's points that are distinct and in [0, 1); sampler (sobol, zsobol or independent), first "
         "(index), "
         "count, dimension",
         distinct_points},
        {"sampler_dimension_correlation",
         "excess of chi-squared of two dimensions over an 8 x 8 grid, in standard deviations; sampler, "
         "dimension, other, first (index), samples",
         dimension_correlation}};
    return table;
}

}  // namespace raylex::experiments
