// Every closure against itself: what sample() draws, what pdf() says of it, and what evaluate() says it is worth.
#include <catch2/catch.hpp>

#include <set>
#include <tuple>
#include <type_traits>

#include "materials_support.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

struct Case {
    std::string name;
    Bsdf bsdf;
    float lobe_width;  // of the narrowest lobe, radians: where the grid must be fine
    bool never_fails = false;
    float least_alpha = 1;
    float eta = 0;  // for glass: the grids' second axis is the refracted direction
};

Bsdf make(const auto& closure) {
    Bsdf bsdf;
    bsdf.set(tilted_frame(), closure);
    return bsdf;
}

const Rgb grey_eta(0.2f, 0.92f, 1.1f), grey_k(3.9f, 2.4f, 2.2f);

/// Closures with an exact density.
std::vector<Case> smooth_density_cases() {
    std::vector<Case> cases;
    cases.push_back({"lambert", make(LambertClosure{{0.2f, 0.5f, 0.8f}}), 1, true});
    for (const float alpha : {0.01f, 0.1f, 0.3f, 1.0f})
        cases.push_back({"conductor " + std::to_string(alpha),
                         make(ConductorClosure{Ggx::from_alpha(alpha, alpha), grey_eta, grey_k, false}), alpha, false,
                         alpha});
    cases.push_back({"conductor 0.5 x 0.1",
                     make(ConductorClosure{Ggx::from_alpha(0.5f, 0.1f), grey_eta, grey_k, false}), 0.15f, false, 0.1f});
    // Stability row 14: one rough axis beside a smooth one. A strip too thin for grids: its normals are tested by
    // themselves.
    cases.push_back({"conductor 0.3 x 0", make(ConductorClosure{Ggx::from_alpha(0.3f, 0), grey_eta, grey_k, false}),
                     0.02f, false, 1e-4f});
    for (const float eta : {1.5f, 1 / 1.5f, 1.05f})
        for (const float alpha : {0.1f, 0.4f}) {
            // At grazing angles this one's density has a caustic that a grid resolves only to 1 %.
            if (eta == 1.05f && alpha == 0.4f) continue;
            cases.push_back({"dielectric " + std::to_string(eta) + " " + std::to_string(alpha),
                             make(DielectricClosure{Ggx::from_alpha(alpha, alpha), eta}), alpha, false, alpha, eta});
        }
    AdditiveClosure additive{{{0.2f, 0.4f, 0.3f}}, {Ggx::from_alpha(0.3f, 0.3f), Rgb(0.5f), Rgb(0), true}};
    cases.push_back({"additive", make(additive), 0.3f, false, 0.3f});
    additive.specular.facets = Ggx::from_alpha(0.3f, 0.06f);
    cases.push_back({"additive anisotropic", make(additive), 0.1f, false, 0.06f});
    return cases;
}

/// Draws N directions; counts in grids about the mirrored (and, for glass, the refracted) direction against the
/// integral of pdf() over each cell. Failures are a cell of their own.
double chi_square_p(const Case& c, const Vec3& wo_local, std::uint64_t seed, double& integral) {
    const Frame frame = c.bsdf.frame();
    const Vec3 wo = frame.to_world(wo_local);
    const bool glass = c.eta > 0;
    const float eta = wo_local.z > 0 ? c.eta : 1 / c.eta;
    const Vec3 mirrored = frame.to_world({-wo_local.x, -wo_local.y, wo_local.z});
    Vec3 through{-wo_local.x / eta, -wo_local.y / eta, 0};
    through.z = std::copysign(safe_sqrt(1 - through.x * through.x - through.y * through.y), -wo_local.z);
    const float bend = std::min(1.0f, 2 * std::abs(1 - 1 / eta));  // of a refracted ray by a tilt of its facet
    const LobeGrid grids[2] = {{mirrored, 2 * c.lobe_width, 10, 12},
                               {frame.to_world(normalize(through)), c.lobe_width * bend, 10, 12}};
    const auto grid_of = [&](const Vec3& w) { return glass && dot(w, frame.n) * wo_local.z < 0 ? 1 : 0; };

    std::vector<double> expected;
    for (int g = 0; g < (glass ? 2 : 1); ++g) {
        const auto part =
            grids[g].integrate([&](const Vec3& w) { return grid_of(w) == g ? c.bsdf.pdf(wo, w) : 0.0f; }, 24);
        expected.insert(expected.end(), part.begin(), part.end());
    }
    integral = 0;
    for (const double e : expected) integral += e;
    expected.push_back(std::max(0.0, 1 - integral));

    constexpr int draws = 40'000;
    std::vector<double> observed(expected.size());
    Random random(seed);
    for (int i = 0; i < draws; ++i) {
        const float u_lobe = random.one();
        const BsdfSample s = c.bsdf.sample(wo, u_lobe, random.two());
        const int g = s.pdf > 0 ? grid_of(s.wi) : 0;
        const auto cell =
            s.pdf > 0 ? static_cast<std::size_t>(g * grids[0].size() + grids[g].cell(s.wi)) : expected.size() - 1;
        observed[cell] += 1;
    }
    double chi2 = 0, pooled_expected = 0, pooled_observed = 0;
    int cells = 0;
    const auto add = [&](double o, double e) {
        chi2 += (o - e) * (o - e) / e;
        ++cells;
    };
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const double e = expected[i] * draws;
        if (e >= 10) add(observed[i], e);  // the usual floor for the chi-square approximation, doubled
        else {
            pooled_expected += e;
            pooled_observed += observed[i];
        }
    }
    if (pooled_expected >= 10) add(pooled_observed, pooled_expected);
    else if (pooled_observed > 10 + 6 * std::sqrt(10.0)) return 0;  // mass where there should be next to none
    return chi_square_tail(chi2, cells - 1);
}

}  // namespace

TEST_CASE("sample draws from the density that pdf states, for every closure, roughness and angle") {
    const std::vector<Case> cases = smooth_density_cases();
    const float cosines[] = {0.95f, 0.5f, 0.1f, -0.7f};
    // One false alarm in a hundred for the whole table (Sidak).
    const double alpha = 1 - std::pow(1 - 0.01, 1.0 / (static_cast<double>(cases.size()) * std::size(cosines)));
    std::uint64_t seed = 1;
    for (const Case& c : cases)
        for (const float cosine : cosines) {
            if (c.least_alpha < 1e-3f) continue;
            double integral = 0;
            const double p = chi_square_p(c, local_direction(cosine), seed++, integral);
            INFO(c.name << ", cos " << cosine << ": p " << p << ", integral of the pdf " << integral);
            CHECK(p > alpha);
            // Midpoint rule on 240 x 288 points: 3e-4 where the horizon cuts through cells.
            CHECK(integral < 1 + 5e-4);
            if (c.never_fails) CHECK(integral == Approx(1).margin(5e-4));
        }
}

TEST_CASE("a sample's weight is its value over its density, and evaluate agrees with both", "[law5]") {
    Random random(77);
    for (const Case& c : smooth_density_cases())
        for (int i = 0; i < 400; ++i) {
            const Vec3 wo = c.bsdf.frame().to_world(local_direction(2 * random.one() - 1, 6 * random.one()));
            const float u_lobe = random.one();
            const BsdfSample s = c.bsdf.sample(wo, u_lobe, random.two());
            if (!(s.pdf > 0)) continue;
            INFO(c.name);
            Rgb sum;
            for (int l = 0; l < s.lobes.count; ++l) sum += s.lobes.entry[static_cast<std::size_t>(l)].value;
            // Two float operations on the way: 4 ulp.
            for (int channel = 0; channel < 3; ++channel)
                CHECK(sum[channel] == Approx(s.weight[channel] * s.pdf).epsilon(4e-7));
            CHECK_FALSE(s.delta);
            CHECK(s.transmitted == (dot(s.wi, c.bsdf.frame().n) * dot(wo, c.bsdf.frame().n) < 0));
            const BsdfEvaluation e = c.bsdf.evaluate(wo, s.wi);
            // The half vector is found anew from directions rounded by 2^-24, and more at grazing angles, where it is
            // a difference: up to 100 times that at the cosines below. Its error counts in units of alpha, twice since
            // the density falls with the square of the slope. At 1e-4 directions are all but used up.
            const double tolerance = std::min(5e-6 + 1.6e-5 / static_cast<double>(c.least_alpha), 0.05);
            const float cos_i = std::abs(dot(s.wi, c.bsdf.frame().n)), cos_o = std::abs(dot(wo, c.bsdf.frame().n));
            if (cos_i < 1e-2f || cos_o < 1e-2f) continue;
            CHECK(e.pdf == Approx(s.pdf).epsilon(tolerance));
            CHECK(e.value.g == Approx(s.weight.g * s.pdf).epsilon(tolerance));
            CHECK(c.bsdf.pdf(wo, s.wi) == Approx(e.pdf).epsilon(1e-6));
        }
}

TEST_CASE("the lobes of a value sum to it exactly", "[law5]") {
    Random random(5);
    std::vector<Case> cases = smooth_density_cases();
    Case coated{"coated", {}, 1};
    coated.bsdf.set(tilted_frame(),
                    LayeredClosure<LambertClosure>{
                        {{Ggx::from_alpha(0.2f, 0.2f), 1.5f}, 0.01f, 0, Rgb(0), 10, 1, false}, {Rgb(0.5f)}},
                    3);
    cases.push_back(coated);
    int seen = 0, several = 0;
    for (const Case& c : cases)
        for (int i = 0; i < 300; ++i) {
            const Vec3 wo = c.bsdf.frame().to_world(sample_uniform_sphere(random.two()));
            const Vec3 wi = c.bsdf.frame().to_world(sample_uniform_sphere(random.two()));
            const BsdfEvaluation e = c.bsdf.evaluate(wo, wi);
            Rgb sum;
            for (int l = 0; l < e.lobes.count; ++l) sum += e.lobes.entry[static_cast<std::size_t>(l)].value;
            CHECK(sum == e.value);
            CHECK((e.pdf > 0 || e.value.is_black()));
            seen += e.pdf > 0;
            several += e.lobes.count > 1 && sum != e.lobes.entry[0].value;
        }
    CHECK(seen > 2000);
    CHECK(several > 200);  // of 900 pairs of directions, half of them on one side: sums of one would prove little
}

TEST_CASE("opaque closures are reciprocal, glass up to the square of its index") {
    Random random(9);
    for (const Case& c : smooth_density_cases())
        for (int i = 0; i < 300; ++i) {
            const Frame& f = c.bsdf.frame();
            const Vec3 a = sample_uniform_sphere(random.two()), b = sample_uniform_sphere(random.two());
            if (std::abs(a.z) < 0.05f || std::abs(b.z) < 0.05f) continue;
            const float ab = c.bsdf.evaluate(f.to_world(a), f.to_world(b)).value.g / std::abs(b.z);
            const float ba = c.bsdf.evaluate(f.to_world(b), f.to_world(a)).value.g / std::abs(a.z);
            // Radiance over the squared index is what is conserved: Veach 1997, (5.14).
            const float index_a = c.eta > 0 && a.z < 0 ? c.eta : 1.0f, index_b = c.eta > 0 && b.z < 0 ? c.eta : 1.0f;
            INFO(c.name);
            // The half vector of a far-off pair through nearly matched glass is a difference of large numbers; the
            // margin is for facets seen edge-on from one side, whose 1 - F is a root of what the other side's rounding
            // leaves.
            CHECK(ab * index_b * index_b == Approx(ba * index_a * index_a).epsilon(2e-4).margin(2e-6));
        }
}

TEST_CASE("no closure returns more light than falls on it") {
    Random random(13);
    for (Case& c : smooth_density_cases())
        for (const float cosine : {1.0f, 0.5f, 0.02f, -0.6f}) {
            const Vec3 wo = c.bsdf.frame().to_world(local_direction(cosine));
            const MeanAndError energy = average(20'000, [&] {
                const float u_lobe = random.one();
                const BsdfSample s = c.bsdf.sample(wo, u_lobe, random.two());
                return s.pdf > 0 ? static_cast<double>(s.weight.b * s.eta * s.eta) : 0.0;  // basic radiance
            });
            INFO(c.name << ", cos " << cosine << ": " << energy.mean);
            CHECK(energy.mean <= 1 + 4 * energy.standard_error + 1e-6);
        }
}

TEST_CASE("Lambert returns exactly its albedo, an ideal mirror its reflectance, at every angle") {
    Random random(15);
    const Bsdf lambert = make(LambertClosure{{0.2f, 0.5f, 0.8f}});
    const Bsdf mirror = make(IdealClosure{Rgb(0), {0.9f, 0.5f, 0.1f}, Rgb(0)});
    const Bsdf sheet = make(IdealClosure{Rgb(0), Rgb(0), {0.9f, 0.5f, 0.1f}});
    for (const float cosine : {1.0f, 0.3f, 1e-3f, -0.4f}) {
        const Frame& f = lambert.frame();
        const Vec3 local = local_direction(cosine), wo = f.to_world(local);
        CHECK(lambert.sample(wo, 0.3f, random.two()).weight == Rgb(0.2f, 0.5f, 0.8f));
        const double albedo = integrate_hemisphere(
            [&](const Vec3& w) {
                return static_cast<double>(
                    lambert.evaluate(wo, f.to_world({w.x, w.y, std::copysign(w.z, cosine)})).value.g);
            },
            64);
        CHECK(albedo == Approx(0.5).epsilon(1e-6));

        const BsdfSample m = mirror.sample(wo, 0.3f, random.two());
        CHECK((m.delta && !m.transmitted && m.pdf == 1));
        CHECK(m.weight.g == 0.5f);
        CHECK(dot(m.wi, f.n) == Approx(cosine).margin(1e-6));
        CHECK(lobe_kinds()[m.lobes.entry[0].lobe].name == std::string("mirror"));

        const BsdfSample s = sheet.sample(wo, 0.3f, random.two());
        CHECK((s.delta && s.transmitted && s.eta == 1));
        CHECK(length(s.wi + wo) < 1e-6f);
        CHECK(s.weight.g == 0.5f);
        CHECK(lobe_kinds()[s.lobes.entry[0].lobe].type == lpe::EventType::transmission);
    }
    CHECK_FALSE(mirror.has_density());
    CHECK_FALSE(sheet.has_density());
}

TEST_CASE("diffuse-mirror picks its lobes in proportion and keeps the furnace's weight") {
    Random random(21);
    const Bsdf both = make(IdealClosure{Rgb(0.5f), Rgb(0.3f), Rgb(0)});
    const Vec3 wo = both.frame().to_world(local_direction(0.6f));
    int mirrored = 0;
    constexpr int draws = 100'000;
    for (int i = 0; i < draws; ++i) {
        const float u_lobe = random.one();
        const BsdfSample s = both.sample(wo, u_lobe, random.two());
        REQUIRE(s.weight.r == Approx(0.8).epsilon(1e-6));
        mirrored += s.delta;
        if (!s.delta) REQUIRE(both.pdf(wo, s.wi) == Approx(s.pdf).epsilon(1e-5));
    }
    // Binomial, p = 3/8: four standard errors.
    CHECK(std::abs(mirrored / static_cast<double>(draws) - 0.375) < 4 * std::sqrt(0.375 * 0.625 / draws));
    CHECK(both.has_density());
}

TEST_CASE("each lobe of the additive surface is what that lobe alone would be", "[law5]") {
    Random random(25);
    const LambertClosure lambert{Rgb(0.3f)};
    const ConductorClosure metal{Ggx::from_alpha(0.3f, 0.3f), Rgb(1), Rgb(2), false};
    const Bsdf sum = make(AdditiveClosure{lambert, metal}), diffuse = make(lambert), specular = make(metal);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 wo = sum.frame().to_world(sample_uniform_sphere(random.two()));
        const Vec3 wi = sum.frame().to_world(sample_uniform_sphere(random.two()));
        const BsdfEvaluation e = sum.evaluate(wo, wi);
        if (e.lobes.count == 0) continue;
        REQUIRE(e.lobes.count == 2);
        CHECK(lobe_kinds()[e.lobes.entry[0].lobe].scatter == lpe::Scatter::diffuse);
        CHECK(lobe_kinds()[e.lobes.entry[1].lobe].scatter == lpe::Scatter::glossy);
        CHECK(e.lobes.entry[0].value.r == Approx(diffuse.evaluate(wo, wi).value.r).epsilon(1e-5));
        CHECK(e.lobes.entry[1].value.r == Approx(specular.evaluate(wo, wi).value.r).epsilon(1e-5));
    }
}

TEST_CASE("extreme random numbers and edge-on directions give finite samples or failures") {
    const float values[] = {0.0f, 0x1p-32f, 0.5f, one_minus_epsilon};
    std::vector<Case> cases = smooth_density_cases();
    for (const float alpha : {0.0f, 1e-3f}) {
        cases.push_back({"metal", make(ConductorClosure{Ggx::from_alpha(alpha, alpha), grey_eta, grey_k, false}), 1});
        cases.push_back({"glass", make(DielectricClosure{Ggx::from_alpha(alpha, alpha), 1.5f}), 1});
        Case coated{"coated", {}, 1};
        coated.bsdf.set(tilted_frame(),
                        LayeredClosure<ConductorClosure>{
                            {{Ggx::from_alpha(alpha, alpha), 1.5f}, 0.01f, 0.9f, Rgb(0.5f), 10, 1, true},
                            {Ggx::from_alpha(0.2f, 0.2f), grey_eta, grey_k, false}},
                        9);
        cases.push_back(coated);
    }
    // Stability row 20: reflectance exactly 1.
    cases.push_back(
        {"perfect metal",
         make(ConductorClosure{Ggx::from_alpha(0.1f, 0.1f), Rgb(1), conductor_k_from_reflectance(Rgb(1)), false}), 1});
    for (const Case& c : cases)
        for (const float cosine : {1.0f, 1e-3f, 1e-6f, 1e-9f, 0.0f, -1e-6f, -1.0f})
            for (const float a : values)
                for (const float b : values)
                    for (const float l : values) {
                        const Vec3 wo = c.bsdf.frame().to_world(local_direction(cosine));
                        const BsdfSample s = c.bsdf.sample(wo, l, {a, b});
                        INFO(c.name << " cos " << cosine << " u " << l << " " << a << " " << b);
                        REQUIRE(std::isfinite(s.pdf));
                        if (!(s.pdf > 0)) continue;
                        REQUIRE((is_finite(s.wi) && is_finite(s.weight)));
                        REQUIRE(length(s.wi) == Approx(1).epsilon(1e-4));
                        const BsdfEvaluation e = c.bsdf.evaluate(wo, s.wi);
                        REQUIRE((is_finite(e.value) && std::isfinite(e.pdf)));
                    }
}

TEST_CASE("closures are small values that batches may copy") {
    CHECK(std::is_trivially_copyable_v<Bsdf>);
    CHECK(sizeof(Bsdf) <= 256);
    const Bsdf nothing;
    CHECK_FALSE(nothing.has_density());
    CHECK(nothing.sample({0, 0, 1}, 0.5f, {0.5f, 0.5f}).pdf == 0);
    Bsdf border;
    border.set_pass_through();
    CHECK(border.passes_through());
    CHECK(border.sample({0, 0, 1}, 0.5f, {0.5f, 0.5f}).pdf == 0);
    // Channels tell lobes apart by event and name.
    std::set<std::tuple<lpe::EventType, lpe::Scatter, std::string>> kinds;
    for (const LobeKind& kind : lobe_kinds()) {
        CHECK(std::string(kind.name) != "");
        CHECK(kinds.emplace(kind.type, kind.scatter, kind.name).second);
    }
}
