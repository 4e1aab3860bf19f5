// Every closure against itself: lobes, weights and values. Densities, energy, reciprocity and edges are cases of
// tests/stability/scattering.toml.
#include <catch2/catch.hpp>

#include <array>
#include <optional>
#include <set>
#include <tuple>
#include <type_traits>

#include "tests/transport/materials_support.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

struct Case {
    std::string name;
    Bsdf bsdf;
    float least_alpha = 1;
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
    cases.push_back({"lambert", make(LambertClosure{{0.2f, 0.5f, 0.8f}})});
    const auto add_conductor = [&](float x, float y) {
        cases.push_back({"conductor " + std::to_string(x) + " x " + std::to_string(y),
                         make(ConductorClosure{Ggx::from_alpha(x, y), grey_eta, grey_k, false}),
                         std::max(std::min(x, y), 1e-4f)});
    };
    for (const float alpha : {0.01f, 0.1f, 0.3f, 1.0f}) add_conductor(alpha, alpha);
    add_conductor(0.5f, 0.1f);
    add_conductor(0.3f, 0);
    for (const float eta : {1.5f, 1 / 1.5f, 1.05f})
        for (const float alpha : {0.1f, 0.4f})
            cases.push_back({"dielectric " + std::to_string(eta) + " " + std::to_string(alpha),
                             make(GlassClosure{{Ggx::from_alpha(alpha, alpha), eta}}), alpha});
    AdditiveClosure additive{{{0.2f, 0.4f, 0.3f}}, {Ggx::from_alpha(0.3f, 0.3f), Rgb(0.5f), Rgb(0), true}};
    cases.push_back({"additive", make(additive), 0.3f});
    additive.specular.facets = Ggx::from_alpha(0.3f, 0.06f);
    cases.push_back({"additive anisotropic", make(additive), 0.06f});
    return cases;
}

}  // namespace

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
    Case coated{"coated", {}};
    coated.bsdf.set(tilted_frame(),
                    LayeredClosure<LambertClosure>{
                        {{Ggx::from_alpha(0.2f, 0.2f), 1.5f}, 0.01f, 0, Rgb(0), 10, 1, false}, {Rgb(0.5f)}, 3});
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

TEST_CASE("a closure that keeps one side draws its lobes alone, with the density of such samples") {
    const CoatLayer coat{{Ggx::from_alpha(0.2f, 0.2f), 1.5f}, 0.01f, 0, Rgb(0), 10, 1, false};
    const DielectricClosure rough{Ggx::from_alpha(0.3f, 0.3f), 1.5f}, smooth{Ggx::from_alpha(0, 0), 1.5f};
    const std::array<Bsdf, 7> choosing{
        make(GlassClosure{rough}),
        make(GlassClosure{smooth}),
        make(GlassClosure{rough, true}),
        make(ThinDielectricClosure{1.5f}),
        make(DiffuseTransmissionClosure{Rgb(0.5f), Rgb(0.3f)}),
        make(LayeredClosure<LambertClosure>{coat, {Rgb(0.5f)}, 3}),
        make(LayeredClosure<ConductorClosure>{coat, {Ggx::from_alpha(0.1f, 0.1f), grey_eta, grey_k, false}, 3})};
    CHECK_FALSE(make(LambertClosure{Rgb(0.5f)}).side_lobes());
    CHECK_FALSE(make(IdealClosure{Rgb(0), Rgb(0.5f), Rgb(0.5f)}).side_lobes());
    Random random(31);
    for (const Bsdf& both : choosing)
        for (const Sides side : {Sides::reflection, Sides::transmission}) {
            const std::optional<SideLobes> lobes = both.side_lobes();
            REQUIRE(lobes);
            Bsdf one = both;
            one.keep_side(side);
            CHECK(one.side_lobes()->reflected == lobes->reflected);
            int drawn = 0;
            for (int i = 0; i < 300; ++i) {
                const Vec3 wo = one.frame().to_world(local_direction(0.9f * random.one() + 0.05f));
                const float u_lobe = random.one();
                const BsdfSample s = one.sample(wo, u_lobe, random.two());
                if (!(s.pdf > 0)) continue;
                ++drawn;
                REQUIRE(s.lobes.count == 1);
                const LobeId lobe = s.lobes.entry[0].lobe;
                if (side == Sides::reflection) CHECK(lobe == lobes->reflected);
                else CHECK((lobe == lobes->passed[0] || lobe == lobes->passed[1]));
                if (!s.delta && !s.pdf_is_proportional) CHECK(one.pdf(wo, s.wi) == s.pdf);
            }
            CHECK(drawn > 100);
        }
}
