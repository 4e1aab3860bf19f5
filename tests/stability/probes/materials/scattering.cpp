// Closures compared with themselves and with references in double: densities, energy, reciprocity, edges.
#include <array>

#include "tests/stability/probes/draws.h"
#include "tests/stability/probes/materials/facet_reference.h"
#include "tests/stability/probes/materials/materials.h"
#include "tests/stability/probes/probes.h"

namespace raylex::experiments {
namespace {

using transport::Bsdf;
using transport::BsdfSample;
using transport::Frame;
using transport::Real;
using transport::Vec2;
using transport::Vec3;

/// Evenly distributed points in the unit cube with several shifts (Roberts' R3 lattice). Integrals converge almost as
/// 1/n, and the shifts give an error estimate.
class EvenPoints {
  public:
    explicit EvenPoints(Draws& draws) : at_{draws.fine(), draws.fine(), draws.fine()} {}
    std::array<Real, 3> next() {
        constexpr std::array<double, 3> step{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
        std::array<Real, 3> point{};
        for (std::size_t i = 0; i < 3; ++i) {
            at_[i] += step[i];
            at_[i] -= at_[i] >= 1 ? 1 : 0;
            point[i] = std::min(static_cast<Real>(at_[i]), transport::one_minus_epsilon);
        }
        return point;
    }

  private:
    std::array<double, 3> at_;
};

/// Returns the mean over samples of `value(sample)`, by 8 shifts of even points.
template <class Value>
Result<ProbeResult> mean_of_samples(const ProbeInput& input, const ProbedBsdf& probed, const Value& value) {
    const auto samples = static_cast<int>(input.number("samples", 131072)) / 8;
    const Vec3 wo = probed.frame.to_world(probed_direction(input));
    Draws draws(11);
    RunningMean mean;
    for (int shift = 0; shift < 8; ++shift) {
        EvenPoints points(draws);
        double sum = 0;
        for (int i = 0; i < samples; ++i) {
            const auto [l, x, y] = points.next();
            const BsdfSample s = probed.bsdf.sample(wo, l, {x, y});
            if (s.pdf > 0) sum += value(s);
        }
        mean.add(sum / samples);
    }
    ProbeResult result;
    result.measured = mean.mean();
    result.standard_error = mean.standard_error();
    result.degrees = 7;
    return result;
}

/// Basic radiance, radiance divided by the squared index, is the conserved quantity.
double basic_weight(const BsdfSample& s) {
    return static_cast<double>(s.weight.average()) * static_cast<double>(s.eta) * static_cast<double>(s.eta);
}

Result<ProbeResult> bsdf_furnace(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    auto result = mean_of_samples(input, *probed, basic_weight);
    if (!result) return result;
    const double reflectance = input.number("reflectance", 1), x = input.number("alpha", 0.3);
    const std::string material = input.word("material");
    if (input.number("compensate", 0) == 0 && (material == "conductor" || material == "dielectric")) {
        const Vec3 wo = probed_direction(input);
        const bool glass = material == "dielectric";
        const double eta = wo.z < 0 ? 1 / probed->eta : probed->eta;
        const transport::Ggx facets =
            transport::Ggx::from_alpha(static_cast<Real>(x), static_cast<Real>(input.number("alpha_y", x)));
        const ReferenceFacets reference{double(facets.alpha_x), double(facets.alpha_y), glass ? eta : 0};
        const bool ideal = facets.smooth() || (glass && std::abs(probed->eta - 1) < 1e-3);
        const auto n = static_cast<int>(input.number("reference", 512));
        result->expected = (ideal ? 1 : reference.albedo({double(wo.x), double(wo.y), std::abs(double(wo.z))}, n)) *
                           (glass ? 1 : reflectance);
    } else {
        result->expected = reflectance;
    }
    return result;
}

Result<ProbeResult> bsdf_largest_weight(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    double largest = 0;
    auto mean = mean_of_samples(input, *probed, [&](const BsdfSample& s) {
        largest = std::max(largest, basic_weight(s));
        return 0.0;
    });
    if (!mean) return mean;
    mean->measured = largest;
    return mean;
}

Result<ProbeResult> bsdf_transmitted(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    return mean_of_samples(input, *probed, [](const BsdfSample& s) { return s.transmitted ? basic_weight(s) : 0; });
}

/// The directions of a closure's lobes: the mirrored direction, and for glass also the refracted one.
struct Lobes {
    std::vector<LobeCells> cells;
    Frame frame;
    bool wo_above;

    Lobes(const ProbedBsdf& probed, const Vec3& wo) : frame(probed.frame), wo_above(wo.z > 0) {
        const Vec3 mirrored = frame.to_world({-wo.x, -wo.y, wo.z});
        cells.emplace_back(probed.about_wo ? probed.forward * -frame.to_world(wo) : mirrored, 2 * probed.width, 10, 12);
        if (!(probed.eta > 0)) return;
        const auto eta = static_cast<Real>(wo_above ? probed.eta : 1 / probed.eta);
        Vec3 through{-wo.x / eta, -wo.y / eta, 0};
        through.z = std::copysign(transport::safe_sqrt(1 - through.x * through.x - through.y * through.y), -wo.z);
        const double bend = std::min(1.0, 2 * std::abs(1 - 1 / static_cast<double>(eta)));
        cells.emplace_back(frame.to_world(normalize(through)), probed.width * bend, 10, 12);
    }
    [[nodiscard]] std::size_t grid_of(const Vec3& w) const {
        return cells.size() > 1 && (dot(w, frame.n) > 0) != wo_above ? 1 : 0;
    }
    [[nodiscard]] std::size_t cell(const Vec3& w) const {
        const std::size_t grid = grid_of(w);
        return grid * cells[0].size() + cells[grid].cell(w);
    }
};

Result<ProbeResult> bsdf_chi_squared(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    const Vec3 local = probed_direction(input), wo = probed->frame.to_world(local);
    const auto draws = static_cast<int>(input.number("samples", 40000));
    const Lobes lobes(*probed, local);
    std::vector<double> expected;
    for (std::size_t g = 0; g < lobes.cells.size(); ++g) {
        const auto part = lobes.cells[g].integrate(
            [&](const Vec3& w) { return lobes.grid_of(w) == g ? probed->bsdf.pdf(wo, w) : Real(0); },
            static_cast<int>(input.number("grid", 16)));
        expected.insert(expected.end(), part.begin(), part.end());
    }
    const double integral = std::accumulate(expected.begin(), expected.end(), 0.0);
    expected.push_back(std::max(0.0, 1 - integral));  // failed samples
    std::vector<double> observed(expected.size());
    Draws random(static_cast<std::uint64_t>(input.number("seed", 1)));
    double deltas = 0;
    for (int i = 0; i < draws; ++i) {
        const Real u_lobe = random.one();
        const BsdfSample s = probed->bsdf.sample(wo, u_lobe, random.two());
        if (s.pdf > 0 && s.delta) deltas += 1;
        else observed[s.pdf > 0 ? lobes.cell(s.wi) : observed.size() - 1] += 1;
    }
    expected.back() = std::max(0.0, expected.back() - deltas / draws);
    for (double& e : expected) e *= draws;
    ProbeResult result;
    result.measured = chi_squared_deviation(observed, expected);
    result.expected = 0;
    result.note = "the density's integral is " + std::to_string(integral);
    return result;
}

Result<ProbeResult> bsdf_pdf_identity(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    const Vec3 wo = probed->frame.to_world(probed_direction(input));
    const auto draws = static_cast<int>(input.number("samples", 50000));
    Draws random(3);
    double largest = 0;
    int with_density = 0;
    for (int i = 0; i < draws; ++i) {
        const Real u_lobe = random.one();
        const BsdfSample s = probed->bsdf.sample(wo, u_lobe, random.two());
        if (!(s.pdf > 0) || s.delta) continue;
        ++with_density;
        const double pdf = probed->bsdf.pdf(wo, s.wi), evaluated = probed->bsdf.evaluate(wo, s.wi).pdf;
        largest = std::max({largest, std::abs(pdf / double(s.pdf) - 1), std::abs(evaluated / pdf - 1)});
    }
    ProbeResult result;
    result.measured = largest;
    result.expected = 0;
    result.note = std::to_string(with_density) + " samples with a density";
    return result;
}

Result<ProbeResult> bsdf_value_identity(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    const Vec3 wo = probed->frame.to_world(probed_direction(input));
    auto mean = mean_of_samples(input, *probed, [&](const BsdfSample& s) {
        if (s.delta) return 0.0;
        const double eta2 = static_cast<double>(s.eta) * static_cast<double>(s.eta);
        return static_cast<double>((probed->bsdf.evaluate(wo, s.wi).value / s.pdf).average()) * eta2;
    });
    auto weights = mean_of_samples(input, *probed, [](const BsdfSample& s) { return s.delta ? 0 : basic_weight(s); });
    if (!mean || !weights) return mean ? weights : mean;
    mean->expected = weights->measured;
    mean->standard_error = 0;  // both means use the same samples
    return mean;
}

/// f(a, b) / index_b^2 for basic radiance is symmetric.
Result<ProbeResult> bsdf_reciprocity(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    const auto pairs = static_cast<int>(input.number("samples", 20000));
    const double least = input.number("least_cosine", 0.05);
    const Frame& frame = probed->frame;
    Draws random(5);
    RunningMean size;
    double largest = 0;
    for (int i = 0; i < pairs; ++i) {
        const Vec3 a = transport::sample_uniform_sphere(random.two()),
                   b = transport::sample_uniform_sphere(random.two());
        if (std::abs(double(a.z)) < least || std::abs(double(b.z)) < least) continue;
        const auto value = [&](const Vec3& o, const Vec3& w) {
            const double index = probed->eta > 0 && w.z < 0 ? probed->eta : 1;
            return double(probed->bsdf.evaluate(frame.to_world(o), frame.to_world(w)).value.average()) * index * index /
                   std::abs(double(w.z));
        };
        const double ab = value(a, b), ba = value(b, a);
        size.add(std::max(ab, ba));
        largest = std::max(largest, std::abs(ab - ba) / std::max({ab, ba, 1e-2}));
    }
    ProbeResult result;
    result.measured = largest;
    result.expected = 0;
    result.note = "mean f " + std::to_string(size.mean()) + "; values below 0.01 count as 0.01";
    return result;
}

/// Counts results that are not finite, negative or not unit vectors, for samples from numbers at the ends of [0, 1) and
/// for evaluations at wi = +-wo and along the normal.
Result<ProbeResult> bsdf_extremes(const ProbeInput& input) {
    auto probed = probed_bsdf(input);
    if (!probed) return probed.error();
    const Bsdf& bsdf = probed->bsdf;
    const Vec3 wo = probed->frame.to_world(probed_direction(input)), n = probed->frame.n;
    int wrong = 0;
    const auto check = [&](const Vec3& out, const Vec3& in) {
        const auto e = bsdf.evaluate(out, in);
        const Real pdf = bsdf.pdf(out, in);
        wrong += !(is_finite(e.value) && std::isfinite(e.pdf) && e.value.r >= 0 && e.value.g >= 0 && e.value.b >= 0 &&
                   e.pdf >= 0 && pdf == e.pdf);
    };
    for (const Vec3& out : {wo, -wo, n, -n})
        for (const Vec3& in : {wo, -wo, n, -n}) check(out, in);
    for (const Real l : {Real(0), Real(0x1p-24), Real(0.5), transport::one_minus_epsilon})
        for (const Real x : {Real(0), Real(0x1p-24), Real(0.5), transport::one_minus_epsilon})
            for (const Real y : {Real(0), Real(0x1p-24), Real(0.5), transport::one_minus_epsilon}) {
                const BsdfSample s = bsdf.sample(wo, l, {x, y});
                wrong += !std::isfinite(s.pdf);
                if (!(s.pdf > 0)) continue;
                // A direction in float is a unit vector up to some roundings of its largest coordinate.
                wrong += !(is_finite(s.wi) && is_finite(s.weight) &&
                           std::abs(double(length_squared(s.wi)) - 1) < 64 * 0x1p-24);
                if (!s.delta) check(wo, s.wi);
            }
    ProbeResult result;
    result.measured = wrong;
    result.expected = 0;
    return result;
}

}  // namespace

std::span<const NamedProbe> scattering_probes() {
    static constexpr NamedProbe table[] = {
        {"bsdf_furnace", "albedo of a material under a white sky: mean of sample weights; materials.h, mu, samples",
         bsdf_furnace},
        {"bsdf_largest_weight", "largest weight of a sample; materials.h, mu, samples", bsdf_largest_weight},
        {"bsdf_transmitted", "fraction of basic radiance that is transmitted; materials.h, mu, samples",
         bsdf_transmitted},
        {"bsdf_chi_squared",
         "excess of Pearson's chi-squared of samples against pdf(), in standard deviations; materials.h, mu, samples, "
         "grid, seed",
         bsdf_chi_squared},
        {"bsdf_pdf_identity",
         "largest relative difference between a sample's pdf and pdf() of its direction; materials.h, mu, samples",
         bsdf_pdf_identity},
        {"bsdf_value_identity",
         "mean of evaluate() / pdf at samples, compared with their weights; materials.h, mu, samples",
         bsdf_value_identity},
        {"bsdf_reciprocity",
         "largest relative difference of f under exchange of directions; materials.h, samples, least_cosine",
         bsdf_reciprocity},
        {"bsdf_extremes", "number of samples and values at the edges that are not finite; materials.h, mu",
         bsdf_extremes}};
    return table;
}

}  // namespace raylex::experiments
