// From parameters to closures: pbrt's names and defaults, batches, mixing, errors, and the lobes announced.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <set>

#include "tests/transport/materials_scene.h"
#include "tests/transport/materials_support.h"
#include "transport/materials/material.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

struct Built {
    TextureTable textures;
    MaterialTable materials;
};

Result<Built> try_build(const SceneDescription& scene) {
    Result<TextureTable> textures = TextureTable::build(scene);
    if (!textures) return textures.error();
    Result<MaterialTable> materials = MaterialTable::build(scene, *textures);
    if (!materials) return materials.error();
    return Built{*std::move(textures), *std::move(materials)};
}

Built build_tables(const SceneDescription& scene) {
    Result<Built> built = try_build(scene);
    INFO((built ? std::string() : built.error().to_string()));
    REQUIRE(built.ok());
    return *std::move(built);
}

SurfacePoint hit(int material, float u = 0, float v = 0, std::uint32_t key = 1) {
    SurfacePoint p;
    p.geometric_normal = p.shading_normal = {0, 0, 1};
    p.dpdu = {1, 0, 0};
    p.wo = {0, 0.6f, 0.8f};
    p.u = u;
    p.v = v;
    p.material = material;
    p.random_key = key;
    return p;
}

Bsdf shade_one(const Built& built, const SurfacePoint& p) {
    Bsdf bsdf;
    built.materials.shade(built.textures, {&p, 1}, {&bsdf, 1});
    return bsdf;
}

Bsdf shade_one(SceneEntity material) {
    SceneDescription scene;
    scene.materials = {std::move(material)};
    return shade_one(build_tables(scene), hit(0));
}

Error error_of(SceneEntity material) {
    SceneDescription scene;
    scene.materials = {entity("diffuse", {}, "white"), std::move(material)};
    const Result<Built> built = try_build(scene);
    REQUIRE_FALSE(built.ok());
    return built.error();
}

const Vec3 up{0, 0, 1};

}  // namespace

TEST_CASE("materials without parameters have pbrt's defaults") {
    CHECK(shade_one(entity("diffuse", {})).albedo(up) == Rgb(0.5f));
    const Bsdf copper = shade_one(entity("conductor", {}));
    CHECK_FALSE(copper.has_density());
    CHECK((copper.albedo(up).r > 0.9f && copper.albedo(up).b < 0.7f));
    const BsdfSample glass = shade_one(entity("dielectric", {})).sample(up, 0.5f, {0.5f, 0.5f});
    CHECK((glass.delta && glass.eta == 1.5f && glass.pdf == Approx(0.96)));
    CHECK(shade_one(entity("thindielectric", {})).holds<ThinDielectricClosure>());
    CHECK(shade_one(entity("interface", {})).passes_through());
    const BsdfSample coat = shade_one(entity("coateddiffuse", {})).sample(up, 0, {0.5f, 0.5f});
    CHECK((coat.delta && coat.pdf == Approx(0.04).epsilon(1e-3)));
    CHECK_FALSE(shade_one(entity("coatedconductor", {})).has_density());
}

TEST_CASE("roughness is square-root remapped unless told otherwise, and anisotropy follows dpdu") {
    const auto value = [](std::vector<Parameter> parameters, const Vec3& wi) {
        parameters.push_back(rgb("reflectance", 0.8, 0.8, 0.8));
        return shade_one(entity("conductor", std::move(parameters))).evaluate(up, normalize(wi)).value.r;
    };
    const Vec3 wi{0.2f, 0.1f, 1};
    CHECK(value({real("roughness", 0.04)}, wi) ==
          Approx(value({real("roughness", 0.2), boolean("remaproughness", false)}, wi)).epsilon(1e-5));
    const std::vector<Parameter> brushed{real("uroughness", 0.5), real("vroughness", 0.05),
                                         boolean("remaproughness", false)};
    CHECK(value(brushed, {0.4f, 0, 1}) > 20 * value(brushed, {0, 0.4f, 1}));
    CHECK_FALSE(shade_one(entity("conductor", {real("roughness", 0.9e-6)})).has_density());  // sqrt(0.9e-6) < 1e-3
    CHECK(shade_one(entity("conductor", {real("roughness", 1.1e-6)})).has_density());
}

TEST_CASE("a conductor's reflectance is its colour at normal incidence, under a coat relative to it") {
    const Bsdf metal = shade_one(entity("conductor", {rgb("reflectance", 0.8, 0.5, 0.2)}));
    for (int c = 0; c < 3; ++c) CHECK(metal.albedo(up)[c] == Approx(Rgb(0.8f, 0.5f, 0.2f)[c]).epsilon(1e-4));
    const Bsdf coated =
        shade_one(entity("coatedconductor", {rgb("reflectance", 0.8, 0.5, 0.2), real("interface.roughness", 0),
                                             real("conductor.roughness", 0.3), real("interface.eta", 1.5)}));
    CHECK(coated.has_density());
    CHECK(coated.albedo(up).r > coated.albedo(up).b);
}

TEST_CASE("a batch in any order gives each hit its own material, in runs without gathering") {
    SceneDescription scene;
    scene.textures = {
        colour_texture("checkerboard", "tiles", {rgb("tex1", 0.9, 0.9, 0.9), rgb("tex2", 0.1, 0.1, 0.1)})};
    scene.materials = {entity("diffuse", {rgb("reflectance", 0.2, 0.2, 0.2)}), entity("dielectric", {}),
                       entity("diffuse", {texture("reflectance", "tiles")})};
    const Built built = build_tables(scene);
    Random random(3);
    for (const std::size_t n : {1u, 7u, 256u, 0u, 1000u}) {
        std::vector<SurfacePoint> points;
        for (std::size_t i = 0; i < n; ++i)
            points.push_back(hit(static_cast<int>(random.one() * 3), random.one() * 2, 0.5f));
        std::vector<Bsdf> closures(n);
        built.materials.shade(built.textures, points, closures);
        for (std::size_t i = 0; i < n; ++i) {
            CHECK(closures[i].holds<GlassClosure>() == (points[i].material == 1));
            if (points[i].material == 0) CHECK(closures[i].albedo(up).r == 0.2f);
            if (points[i].material == 2) CHECK(closures[i].albedo(up).r == (points[i].u < 1 ? 0.9f : 0.1f));
        }
    }
}

TEST_CASE("mix takes the second material with the probability of its amount, and nothing at the ends") {
    SceneDescription scene;
    scene.textures = {real_texture("checkerboard", "where", {real("tex1", 0), real("tex2", 1)})};
    scene.materials = {entity("diffuse", {rgb("reflectance", 0.2, 0.2, 0.2)}, "dark"),
                       entity("diffuse", {rgb("reflectance", 0.8, 0.8, 0.8)}, "light")};
    Parameter names = string("materials", "dark");
    names.strings.push_back("light");
    scene.materials.push_back(entity("mix", {names, real("amount", 0.3)}, "blend"));
    scene.materials.push_back(entity("mix", {names, texture("amount", "where")}));
    Parameter nested = string("materials", "dark");
    nested.strings.push_back("blend");
    scene.materials.push_back(entity("mix", {nested, real("amount", 0.5)}));
    const Built built = build_tables(scene);
    constexpr int n = 40'000;
    std::array<int, 3> light{};
    for (std::uint32_t key = 0; key < n; ++key) {
        light[0] += shade_one(built, hit(2, 0, 0, key)).albedo(up).r == 0.8f;
        light[1] += shade_one(built, hit(3, 0.5f, 0.5f, key)).albedo(up).r == 0.8f;
        light[2] += shade_one(built, hit(4, 0, 0, key)).albedo(up).r == 0.8f;
    }
    // Binomial: four standard errors. Nested choices are independent: 0.5 x 0.3.
    CHECK(std::abs(light[0] / static_cast<double>(n) - 0.3) < 4 * std::sqrt(0.3 * 0.7 / n));
    CHECK(light[1] == 0);
    CHECK(std::abs(light[2] / static_cast<double>(n) - 0.15) < 4 * std::sqrt(0.15 * 0.85 / n));
    CHECK(shade_one(built, hit(3, 1.5f, 0.5f, 9)).albedo(up).r == 0.8f);
    CHECK(shade_one(built, hit(2, 0, 0, 5)).albedo(up) == shade_one(built, hit(2, 0, 0, 5)).albedo(up));
}

TEST_CASE("every lobe that closures give was announced by their material", "[law4]") {
    std::vector<SceneEntity> materials{
        entity("diffuse", {}),
        entity("conductor", {}),
        entity("conductor", {real("roughness", 0.1)}),
        entity("dielectric", {}),
        entity("dielectric", {real("roughness", 0.1)}),
        entity("dielectric", {real("roughness", 0.1), real("eta", 1)}),
        entity("conductor", {real("roughness", 0.1), boolean("raylex:compensate", true)}),
        entity("dielectric", {real("roughness", 0.1), boolean("raylex:compensate", true)}),
        entity("thindielectric", {}),
        entity("coateddiffuse", {}),
        entity("coateddiffuse", {real("roughness", 0.1)}),
        entity("coatedconductor", {}),
        entity("coatedconductor", {real("interface.roughness", 0.1)}),
        entity("coatedconductor", {rgb("albedo", 0.9, 0.9, 0.9), real("thickness", 1)}),
        entity("coatedconductor", {real("conductor.roughness", 0.1)}),
        entity("interface", {}),
        entity("diffusetransmission", {}),
        entity("diffusetransmission", {rgb("reflectance", 0, 0, 0)}),
        entity("hair", {}),
        entity("subsurface", {}),
        entity("subsurface", {real("roughness", 0.1)}),
        entity("subsurface", {real("roughness", 0.1), real("eta", 1)}),
        entity("raylex:additive", {}),
        entity("raylex:mirror", {}),
        entity("raylex:diffuse-mirror", {}),
        entity("raylex:sheet", {})};
    SceneDescription scene;
    scene.materials = materials;
    const Built built = build_tables(scene);
    Random random(2);
    for (std::size_t m = 0; m < materials.size(); ++m) {
        std::vector<LobeId> announced;
        built.materials.material(m)->append_lobes(announced);
        std::set<LobeId> seen;
        for (int i = 0; i < 2000; ++i) {
            const Bsdf bsdf = shade_one(built, hit(static_cast<int>(m), 0, 0, random.bits()));
            const Vec3 wo = sample_uniform_sphere(random.two());
            const float u_lobe = random.one();
            const BsdfSample s = bsdf.sample(wo, u_lobe, random.two());
            for (int l = 0; l < s.lobes.count; ++l) seen.insert(s.lobes.entry[static_cast<std::size_t>(l)].lobe);
            const BsdfEvaluation e = bsdf.evaluate(wo, sample_uniform_sphere(random.two()));
            for (int l = 0; l < e.lobes.count; ++l) seen.insert(e.lobes.entry[static_cast<std::size_t>(l)].lobe);
        }
        INFO(materials[m].type << " #" << m);
        const std::set<LobeId> expected(announced.begin(), announced.end());
        CHECK(seen == expected);
    }
}

TEST_CASE("compensation is asked for, keeps lobes and densities, and knows any roughness but one of two by texture") {
    const auto metal = [](bool compensated, std::vector<Parameter> more) {
        more.push_back(real("roughness", 0.5));
        more.push_back(boolean("remaproughness", false));
        more.push_back(boolean("raylex:compensate", compensated));
        return shade_one(entity("conductor", std::move(more)));
    };
    const Bsdf plain = metal(false, {}), whole = metal(true, {});
    const Vec3 wo = local_direction(0.4f), wi = local_direction(0.6f, 2);
    CHECK(plain.holds<ConductorClosure>());
    CHECK(whole.holds<CompensatedConductor>());
    CHECK(whole.pdf(wo, wi) == plain.pdf(wo, wi));
    CHECK(whole.evaluate(wo, wi).lobes.entry[0].lobe == plain.evaluate(wo, wi).lobes.entry[0].lobe);
    CHECK(whole.evaluate(wo, wi).value.r > 1.1f * plain.evaluate(wo, wi).value.r);
    // A factor of the camera's direction alone: not reciprocal, and said so.
    CHECK(whole.evaluate(wo, wi).value.r / plain.evaluate(wo, wi).value.r ==
          Approx(whole.evaluate(wo, local_direction(0.9f)).value.r / plain.evaluate(wo, local_direction(0.9f)).value.r)
              .epsilon(1e-5));
    CHECK(metal(true, {real("vroughness", 0.1)}).holds<CompensatedConductor>());
    // Nothing to compensate: mirrors, and glass that is no interface.
    CHECK(shade_one(entity("conductor", {boolean("raylex:compensate", true)})).holds<ConductorClosure>());
    CHECK(shade_one(entity("dielectric", {real("roughness", 0.5), real("eta", 1), boolean("raylex:compensate", true)}))
              .holds<GlassClosure>());
    const Bsdf glass = shade_one(entity("dielectric", {real("roughness", 0.2), boolean("raylex:compensate", true)}));
    CHECK(glass.inside_ior() == 1.5f);
    CHECK(glass.albedo(wo) == Rgb(1));

    SceneDescription scene;
    scene.textures = {real_texture("constant", "half", {real("value", 0.5)}),
                      real_texture("checkerboard", "board", {real("tex1", 0), real("tex2", 0.5)})};
    scene.materials = {
        entity("conductor", {texture("roughness", "board"), boolean("raylex:compensate", true)}),
        entity("dielectric", {texture("uroughness", "board"), boolean("raylex:compensate", true)}, "glass")};
    const Result<Built> uneven = try_build(scene);
    REQUIRE_FALSE(uneven.ok());
    CHECK(uneven.error().message.find("a texture for one of two roughnesses") != std::string::npos);
    scene.materials.pop_back();
    const Built even = build_tables(scene);  // smooth tiles beside rough ones
    CHECK(shade_one(even, hit(0, 0.25f, 0.25f)).holds<ConductorClosure>());
    CHECK(shade_one(even, hit(0, 0.25f, 1.25f)).holds<CompensatedConductor>());
}

TEST_CASE("the analytic materials are built from their parameters") {
    const Bsdf both =
        shade_one(entity("raylex:diffuse-mirror", {rgb("diffuse", 0.5, 0.5, 0.5), rgb("specular", 0.3, 0.3, 0.3)}));
    CHECK(both.albedo(up).r == Approx(0.8));
    const Bsdf sheet = shade_one(entity("raylex:sheet", {rgb("transmittance", 0.7, 0.7, 0.7)}));
    CHECK((sheet.sample(up, 0.2f, {0.5f, 0.5f}).transmitted && sheet.albedo(up).r == 0.7f));
    const Bsdf constant = shade_one(entity(
        "raylex:additive", {rgb("diffuse", 0.2, 0.2, 0.2), rgb("specular", 0.4, 0.4, 0.4), real("roughness", 0.3),
                            boolean("remaproughness", false), boolean("constantreflectance", true)}));
    CHECK(constant.albedo({0, 0.99f, 0.1f}).r == Approx(0.6));
    CHECK(
        shade_one(entity("raylex:mirror", {rgb("reflectance", 0.9, 0.9, 0.9)})).sample(up, 0.5f, {0.5f, 0.5f}).weight ==
        Rgb(0.9f));
}

TEST_CASE("mistakes in materials are located and name what was expected") {
    Error e = error_of(entity("difuse", {}));
    CHECK((e.line == 5 && e.hint == "did you mean 'diffuse'?"));
    CHECK(e.message.find("coateddiffuse") != std::string::npos);
    e = error_of(entity("diffuse", {texture("reflectance", "wood")}));
    CHECK((e.line == 7 && e.message.find("wood") != std::string::npos));
    e = error_of(entity("diffuse", {texture("displacement", "bumps")}));
    CHECK((e.line == 7 && e.message.find("displacement") != std::string::npos));
    e = error_of(entity("diffuse", {string("normalmap", "n.png")}));
    CHECK((e.line == 7 && e.message.find("n.png") != std::string::npos));
    e = error_of(entity("conductor", {rgb("reflectance", 1, 1, 1), string("eta", "metal-Au-eta")}));
    CHECK(e.message.find("both given") != std::string::npos);
    e = error_of(entity("conductor", {real("roughness", -1)}));
    CHECK(e.message.find("roughness") != std::string::npos);
    e = error_of(entity("dielectric", {real("eta", -1.5)}));
    CHECK((e.line == 7 && e.message.find("eta") != std::string::npos));
    e = error_of(entity("coateddiffuse", {parameter(ParameterType::integer, "maxdepth", {-1})}));
    CHECK(e.message.find("0 to 10000") != std::string::npos);
    e = error_of(entity("coateddiffuse", {parameter(ParameterType::integer, "nsamples", {0})}));
    CHECK(e.message.find("1 to 10000") != std::string::npos);
    e = error_of(entity("mix", {}));
    CHECK(e.message.find("materials") != std::string::npos);
    Parameter names = string("materials", "white");
    names.strings.push_back("wite");
    e = error_of(entity("mix", {names}));
    CHECK((e.line == 7 && e.hint == "did you mean 'white'?"));
    SceneDescription with_interface;
    names.strings[1] = "border";
    with_interface.materials = {entity("diffuse", {}, "white"), entity("interface", {}, "border"),
                                entity("mix", {names})};
    const Result<Built> with_share = try_build(with_interface);
    REQUIRE(with_share.ok());
    const std::vector<TextureId> shares = with_share->materials.surface_shares();
    CHECK((shares[0] == -1 && shares[1] == -1));
    REQUIRE(shares[2] >= 0);
    CHECK(with_share->textures.real(shares[2], {}) == 0.5f);
}

TEST_CASE("walks of no layers leave what a coat reflects, as in pbrt") {
    const auto one = [](std::vector<Parameter> parameters) {
        parameters.push_back(real("roughness", 0.1));
        return shade_one(entity("coateddiffuse", std::move(parameters)));
    };
    const Bsdf only_coat = one({parameter(ParameterType::integer, "maxdepth", {0})}),
               black_base = one({rgb("reflectance", 0, 0, 0)}), usual = one({});
    const Vec3 wi = normalize(Vec3{0.2f, 0.1f, 1});
    CHECK(only_coat.evaluate(up, wi).value == black_base.evaluate(up, wi).value);
    CHECK(only_coat.evaluate(up, wi).value.r < usual.evaluate(up, wi).value.r);
    CHECK(only_coat.sample(up, 0, {0.5f, 0.5f}).pdf > 0);
    CHECK(only_coat.sample(up, 0.9f, {0.5f, 0.5f}).pdf == 0);
}

TEST_CASE("a negative alpha is smooth, as in pbrt, with a warning") {
    SceneDescription scene;
    scene.materials = {entity("conductor", {real("roughness", -0.5), boolean("remaproughness", false)})};
    const Built built = build_tables(scene);
    CHECK_FALSE(shade_one(built, hit(0)).has_density());
    REQUIRE(built.textures.warnings().size() == 1);
    CHECK(built.textures.warnings()[0].message.find("is -0.500000; expected 0 or more, and it is taken as 0") !=
          std::string::npos);
    CHECK(built.textures.warnings()[0].line == 5);
}

TEST_CASE("parameters that nothing reads stay unused, for the caller to report") {
    SceneDescription scene;
    scene.materials = {
        entity("diffuse", {rgb("reflectance", 0.5, 0.5, 0.5), real("sigma", 20), real("displacement", 0)})};
    build_tables(scene);
    const auto unused = scene.materials[0].parameters.unused();
    REQUIRE(unused.size() == 1);
    CHECK(unused[0]->name == "sigma");
}
