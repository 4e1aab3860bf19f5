// Hair and diffuse transmission: densities, energy, lobes, colours, and agreement of all methods.
#include "transport/materials/closures/hair.h"
#include "transport/materials_support.h"
#include "transport/replicates.h"

#include <algorithm>

using namespace raylex::transport;
using namespace raylex::test;
using render_test::integrator_named;

namespace {

Bsdf hair_of(Real h, Real beta_m, Real beta_n, const Rgb& sigma_a, Real alpha = 2) {
    Bsdf bsdf;
    bsdf.set(tilted_frame(), HairClosure({h, Real(1.55), sigma_a, beta_m, beta_n, alpha}));
    return bsdf;
}

Bsdf leaf_of(const Rgb& reflectance, const Rgb& transmittance) {
    Bsdf bsdf;
    bsdf.set(tilted_frame(), DiffuseTransmissionClosure{reflectance, transmittance});
    return bsdf;
}

struct NamedBsdf {
    std::string name;
    Bsdf bsdf;
};

std::vector<NamedBsdf> fibres_and_leaves() {
    return {{"wide hair", hair_of(0.3f, 0.9f, 0.8f, {0.1f, 0.4f, 0.9f})},
            {"hair", hair_of(-0.6f, 0.3f, 0.3f, {0.2f, 0.5f, 1.3f})},
            {"fine hair", hair_of(0.1f, 0.15f, 0.2f, Rgb(0.1f))},
            {"edge of a hair", hair_of(0.98f, 0.4f, 0.5f, Rgb(0.3f))},
            {"white hair", hair_of(0.5f, 0.5f, 0.6f, Rgb(0))},
            {"leaf", leaf_of({0.2f, 0.5f, 0.1f}, {0.3f, 0.4f, 0.05f})},
            {"paper that only passes light", leaf_of(Rgb(0), Rgb(0.7f))},
            {"what only reflects", leaf_of(Rgb(0.4f), Rgb(0))}};
}

}  // namespace

TEST_CASE("fibres and leaves: weight times density is the value, and each lobe its part", "[materials][law5]") {
    Random random(31);
    for (const NamedBsdf& c : fibres_and_leaves()) {
        CAPTURE(c.name);
        int drawn = 0;
        for (int i = 0; i < 500; ++i) {
            const Vec3 wo = sample_uniform_sphere(random.two());
            const float u_lobe = random.one();
            const BsdfSample s = c.bsdf.sample(wo, u_lobe, random.two());
            if (!(s.pdf > 0)) continue;
            ++drawn;
            const BsdfEvaluation e = c.bsdf.evaluate(wo, s.wi);
            CHECK(s.pdf == c.bsdf.pdf(wo, s.wi));
            CHECK(e.pdf == s.pdf);
            Rgb sum, of_sample;
            for (int l = 0; l < e.lobes.count; ++l) sum += e.lobes.entry[static_cast<std::size_t>(l)].value;
            for (int l = 0; l < s.lobes.count; ++l) of_sample += s.lobes.entry[static_cast<std::size_t>(l)].value;
            CHECK(sum == e.value);
            CHECK(s.transmitted == (dot(s.wi, c.bsdf.frame().n) * dot(wo, c.bsdf.frame().n) < 0));
            // Directions are rounded by 2^-24 between sample and evaluate; lobes as narrow as 0.01 rad (the variance of
            // TT at beta 0.15) change by that over 0.01, twice.
            for (int k = 0; k < 3; ++k) {
                CHECK(s.weight[k] * s.pdf == Approx(e.value[k]).epsilon(3e-5).margin(1e-12));
                CHECK(of_sample[k] == Approx(e.value[k]).epsilon(3e-5).margin(1e-12));
            }
        }
        CHECK(drawn > 490);  // a leaf seen along its plane sends nothing
    }
}

TEST_CASE("fibres and leaves are sampled as their densities say", "[materials][statistical][gate]") {
    Random random(33);
    for (const NamedBsdf& c : fibres_and_leaves())
        for (const float cosine : {0.9f, 0.2f, -0.6f}) {
            const Vec3 wo = c.bsdf.frame().to_world(local_direction(cosine, 1.1f));
            // TT of the fine hair is narrowest, about the direction straight on.
            const LobeGrid grid(-wo, 0.3f, 24, 32);
            const auto expected =
                grid.integrate([&](const Vec3& w) { return static_cast<double>(c.bsdf.pdf(wo, w)); }, 12);
            double whole = 0;
            for (const double each : expected) whole += each;
            CAPTURE(c.name, cosine, whole);
            // The midpoint rule on 288 x 384 points of lobes of 0.02 rad and more; half spheres end inside of cells.
            CHECK(whole == Approx(1).epsilon(5e-3));
            constexpr int n = 400'000;
            std::vector<double> found(expected.size());
            int drawn = 0;
            for (int i = 0; i < n; ++i) {
                const float u_lobe = random.one();
                const BsdfSample s = c.bsdf.sample(wo, u_lobe, random.two());
                if (!(s.pdf > 0)) continue;
                ++drawn;
                ++found[static_cast<std::size_t>(grid.cell(s.wi))];
            }
            CHECK(drawn > n - 10);
            double statistic = 0, pooled_expected = 0, pooled_found = 0;
            int cells = 0;
            const auto add = [&](double e, double f) {
                // The rule's error of 5e-3 a cell at worst stands beside the binomial one.
                statistic += (f - e) * (f - e) / (e + 2.5e-5 * e * e);
                ++cells;
            };
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const double e = expected[i] * n;
                if (e >= 20) add(e, found[i]);
                else pooled_expected += e, pooled_found += found[i];
            }
            if (pooled_expected >= 20) add(pooled_expected, pooled_found);
            CAPTURE(statistic, cells);
            CHECK(chi_square_tail(statistic, cells - 1) > 1e-4 / 24);  // 24 tests: one false alarm in 10,000 runs
        }
}

TEST_CASE("hair that absorbs nothing returns all light, other hair what its albedo says", "[materials][gate]") {
    Random random(35);
    for (const Rgb& sigma_a : {Rgb(0), Rgb(0.2f, 0.6f, 1.5f)})
        for (const float beta : {0.1f, 0.3f, 0.6f, 1.0f})
            for (const float h : {-0.95f, -0.4f, 0.0f, 0.7f}) {
                const Bsdf hair = hair_of(h, beta, beta, sigma_a);
                const Vec3 wo = sample_uniform_sphere(random.two());
                const Rgb albedo = hair.albedo(wo);
                CAPTURE(beta, h, sigma_a.g);
                // By its own samples: the mean weight is the integral of f |cos|. Without colour there is no noise at
                // all: chances are in proportion to what is left.
                const auto mean = average(20'000, [&] {
                    const float u_lobe = random.one();
                    return static_cast<double>(hair.sample(wo, u_lobe, random.two()).weight.g);
                });
                if (sigma_a.is_black()) CHECK(mean.mean == Approx(1).epsilon(1e-5));
                CHECK(std::abs(mean.mean - static_cast<double>(albedo.g)) <=
                      4.5 * mean.standard_error + 1e-5);  // 32 tests: by chance once in 4,600 runs
                // And by directions drawn evenly over the sphere, which knows nothing of its density (wide lobes only).
                if (beta < 0.3f) continue;
                const auto even = average(250'000, [&] {
                    return static_cast<double>(hair.evaluate(wo, sample_uniform_sphere(random.two())).value.g) * 4 *
                           static_cast<double>(pi);
                });
                CHECK(std::abs(even.mean - static_cast<double>(albedo.g)) <= 4.5 * even.standard_error);
                CHECK(even.standard_error < 0.02);
            }
}

TEST_CASE("hair's colours: melanin, reflectance and absorption, in the order in which they win", "[materials]") {
    CHECK(hair_absorption_of_melanin(1, 0).r == Approx(0.419));
    CHECK(hair_absorption_of_melanin(0, 2).b == Approx(2.1));
    // Chiang et al., equation 9, at beta_n = 0.3: 5.969 - .0645 + .22788 - .28971 + .0451494 + .00059535
    const Real fit = 5.88841f;
    const Rgb sigma = hair_absorption_of_reflectance({0.5f, 0.25f, 1}, 0.3f);
    CHECK(sigma.r == Approx(std::pow(std::log(0.5) / fit, 2)).epsilon(1e-5));
    CHECK(sigma.g == Approx(std::pow(std::log(0.25) / fit, 2)).epsilon(1e-5));
    CHECK(sigma.b == 0);
    CHECK(is_finite(Vec3{hair_absorption_of_reflectance(Rgb(0), 1).r, 0, 0}));

    const auto albedo = [](const std::string& parameters) {
        const auto scene = render_test::scene_of("WorldBegin Material \"hair\" " + parameters + " Shape \"sphere\"");
        auto textures = TextureTable::build(scene);
        REQUIRE(textures.ok());
        auto materials = MaterialTable::build(scene, *textures);
        INFO((materials.ok() ? std::string() : materials.error().to_string()));
        REQUIRE(materials.ok());
        SurfacePoint point;
        point.shading_normal = point.geometric_normal = point.wo = {0, 0, 1};
        point.dpdu = {1, 0, 0};
        point.v = 0.6f;
        point.material = static_cast<int>(scene.materials.size()) - 1;
        Bsdf bsdf;
        materials->shade(*textures, {&point, 1}, {&bsdf, 1});
        REQUIRE(bsdf.holds<HairClosure>());
        return bsdf.albedo(point.wo);
    };
    CHECK(albedo("") == albedo("\"float eumelanin\" 1.3"));
    CHECK(albedo("\"rgb sigma_a\" [.838 1.394 2.74] \"rgb reflectance\" [1 1 1] \"float eumelanin\" 9").g ==
          Approx(albedo("\"float eumelanin\" 2").g).epsilon(1e-5));
    CHECK(albedo("\"float pheomelanin\" 1").b == Approx(albedo("\"rgb sigma_a\" [.187 .4 1.05]").b).epsilon(1e-5));
    CHECK(albedo("\"rgb color\" [.5 .3 .1]") == albedo("\"rgb reflectance\" [.5 .3 .1] \"float pheomelanin\" 3"));
    CHECK(albedo("\"float eumelanin\" 0.3").g > albedo("\"float eumelanin\" 3").g);
    const auto build = [](const std::string& parameters) {
        return BuiltScene::build(
            render_test::scene_of("WorldBegin Material \"hair\" " + parameters + " Shape \"sphere\""));
    };
    const auto refused = build("\"float eta\" 0.9");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().to_string().find("expected") != std::string::npos);
    CHECK(refused.error().line == 1);
    // As in pbrt.
    for (const char* beyond : {"\"float beta_m\" 1.5", "\"float beta_n\" -1"}) {
        const auto built = build(beyond);
        REQUIRE(built.ok());
        REQUIRE((*built)->warnings.size() == 1);
        CHECK((*built)->warnings[0].message.find("expected 0 to 1, and the nearer of them is taken") !=
              std::string::npos);
        CHECK((*built)->warnings[0].line == 1);
    }
    const auto value = [](Real beta_m, Real beta_n) {
        return hair_of(Real(0.2), beta_m, beta_n, Rgb(Real(0.4)))
            .evaluate(normalize(Vec3{Real(0.1), Real(0.3), 1}), normalize(Vec3{Real(0.2), Real(-0.4), 1}))
            .value;
    };
    CHECK(value(Real(1.5), Real(0.3)) == value(1, Real(0.3)));
    CHECK(value(Real(0.3), -1) == value(Real(0.3), 0));
}

TEST_CASE("diffuse transmission: each side's albedo, colours above 1 cut", "[materials]") {
    const auto closure = [](const std::string& parameters) {
        const auto scene =
            render_test::scene_of("WorldBegin Material \"diffusetransmission\" " + parameters + " Shape \"sphere\"");
        auto textures = TextureTable::build(scene);
        auto materials = MaterialTable::build(scene, *textures);
        REQUIRE(materials.ok());
        SurfacePoint point;
        point.shading_normal = point.geometric_normal = {0, 0, 1};
        point.material = static_cast<int>(scene.materials.size()) - 1;
        Bsdf bsdf;
        materials->shade(*textures, {&point, 1}, {&bsdf, 1});
        return bsdf;
    };
    const Vec3 up = local_direction(0.7f), down = -local_direction(0.4f, 2);
    const Bsdf plain = closure("");
    CHECK(plain.evaluate(up, local_direction(0.4f, 2)).value.r == Approx(0.25 * 0.4 / 3.14159265).epsilon(1e-5));
    CHECK(plain.evaluate(up, down).value.r == Approx(0.25 * 0.4 / 3.14159265).epsilon(1e-5));
    const Bsdf bright = closure("\"rgb reflectance\" [.2 .4 .6] \"rgb transmittance\" [.1 .1 .1] \"float scale\" 2");
    CHECK(bright.albedo(up).r == Approx(0.6));
    CHECK(bright.albedo(up).b == Approx(1.2));  // 1 and 0.2
    CHECK(bright.evaluate(down, -up).value.b == Approx(0.7 / 3.14159265).epsilon(1e-5));
    CHECK_FALSE(closure("\"float scale\" 0").has_density());
}

TEST_CASE("leaves and hair are seen alike from the camera and from lights",
          "[materials][bdpt][lighttracer][statistical][gate]") {
    std::string text = render_test::room;
    const auto put = [&](const std::string& old, const std::string& material) {
        text.replace(text.find(old), old.size(), material);
    };
    put("Material \"dielectric\"", R"(Material "hair" "float eumelanin" 0.3 "float beta_m" 0.5 "float beta_n" 0.6)");
    put("Material \"coateddiffuse\" \"rgb reflectance\" [0.2 0.5 0.7] \"float roughness\" 0.05",
        R"(Material "diffusetransmission" "rgb reflectance" [.2 .3 .4] "rgb transmittance" [.5 .4 .3])");
    RenderSettings settings;
    settings.paths.max_depth = 4;
    settings.samples.per_pixel = 192;
    settings.film.resolution = {{18, 18}};
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    render_test::compare_with_path(text, settings, integrator_named(integrator), 12, 192,
                                   {"C<RD>[LB]", "C<TD><TD>[LB]", "C<RG.'R'>.*[LB]", "C<TG.'TT'><.G>.*[LB]",
                                    "C<RD><TD>.*[LB]", "C<RG.'TRT'>.*[LB]", "C<RD><.G.'TT'>.*[LB]"});
}
