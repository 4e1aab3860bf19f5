// Measured materials: tables of surfaces that are known in closed form, read back.
#include "transport/materials/closures/measured.h"
#include "transport/materials_support.h"
#include "transport/measured_file.h"
#include "transport/replicates.h"

#include "transport/color/spectrum.h"

using namespace raylex::transport;
using namespace raylex::test;
using measured_test::file_of;
using measured_test::Resolution;

namespace {

std::shared_ptr<const MeasuredReflectance> read_back(const Folder& folder, const measured_test::Surface& surface,
                                                     const Resolution& resolution = {}) {
    auto table = MeasuredReflectance::read(folder.write("m.bsdf", file_of(surface, resolution)), {});
    INFO((table.ok() ? std::string() : table.error().to_string()));
    REQUIRE(table.ok());
    return *std::move(table);
}

Bsdf closure_of(const std::shared_ptr<const MeasuredReflectance>& table) {
    Bsdf bsdf;
    bsdf.set(tilted_frame(), MeasuredClosure{table.get()});
    return bsdf;
}

/// f |cos| of the surface itself.
double exact(const measured_test::Surface& surface, const Vec3& wo, const Vec3& wi) {
    const Vec3 m = normalize(wo + wi);
    const auto d = [](const Vec3& v) { return measured_test::Direction{double{v.x}, double{v.y}, double{v.z}}; };
    return surface.rest(d(wo), d(wi), d(m)) * surface.normals(d(m)) / (4 * surface.area(d(wo)));
}

}  // namespace

TEST_CASE("a tabulated surface is the surface: Lambert, and GGX alike in all directions or not",
          "[materials][measured][gate]") {
    const Folder folder;
    struct Case {
        const char* what;
        measured_test::Surface surface;
        int phi;
    };
    const Case cases[] = {{"Lambert", measured_test::lambert(0.6), 1},
                          {"GGX", measured_test::ggx(0.4, 0.4, 0.8), 1},
                          {"anisotropic GGX", measured_test::ggx(0.3, 0.6, 0.8), 9}};
    Random random(41);
    for (const Case& c : cases) {
        Resolution resolution;
        resolution.phi = c.phi;
        const auto table = read_back(folder, c.surface, resolution);
        for (const int node : {0, 1, 2, 3}) {
            const Real theta = static_cast<Real>(node) * 1.4f / 4, phi = pi * static_cast<Real>(node - 2) / 4;
            const Vec3 wo{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
            double worst = 0, mean = 0;
            constexpr int n = 2000;
            for (int i = 0; i < n; ++i) {
                const Vec3 wi = sample_cosine_hemisphere(random.two());
                if (wi.z < 0.1f) continue;
                const double difference =
                    std::abs(static_cast<double>(table->value(wo, wi).g) - exact(c.surface, wo, wi));
                worst = std::max(worst, difference);
                mean += difference / n;
            }
            CAPTURE(c.what, node, worst, mean);
            // Bilinear tables of 64 and 32 nodes: second derivatives of order 1 to 10 over 8 x 32^2 in the mean, more
            // where the horizon cuts the square.
            CHECK(mean < 3e-3);
            CHECK(worst < 0.15);
            // Both sides alike.
            const Vec3 wi = local_direction(0.6f, 1);
            CHECK(table->value(-wo, -wi) == table->value(wo, wi));
            CHECK(table->value(wo, -wi).is_black());
        }
    }
}

TEST_CASE("measured surfaces are sampled as their densities say, and return what their albedo says",
          "[materials][measured][statistical][gate]") {
    const Folder folder;
    Resolution around;
    around.phi = 9;
    const std::shared_ptr<const MeasuredReflectance> tables[] = {
        read_back(folder, measured_test::lambert(0.6)), read_back(folder, measured_test::ggx(0.3, 0.3, 0.8)),
        read_back(folder, measured_test::ggx(0.3, 0.6, 0.8), around)};
    Random random(43);
    for (const auto& table : tables) {
        const Bsdf bsdf = closure_of(table);
        for (const float cosine : {0.95f, 0.5f, -0.3f}) {
            const Vec3 local = local_direction(cosine, 1.3f), wo = bsdf.frame().to_world(local);
            const LobeGrid grid(bsdf.frame().to_world({-local.x, -local.y, local.z}), 0.5f, 12, 16);
            const auto expected =
                grid.integrate([&](const Vec3& w) { return static_cast<double>(bsdf.pdf(wo, w)); }, 24);
            constexpr int n = 200'000;
            std::vector<double> found(expected.size());
            double lost = 0;
            for (int i = 0; i < n; ++i) {
                const BsdfSample s = bsdf.sample(wo, 0.5f, random.two());
                if (!(s.pdf > 0)) {
                    ++lost;
                    continue;
                }
                CHECK(s.pdf == bsdf.pdf(wo, s.wi));
                ++found[static_cast<std::size_t>(grid.cell(s.wi))];
                if (i % 100 != 0) continue;
                const BsdfEvaluation e = bsdf.evaluate(wo, s.wi);
                // Tables are looked up where rounding leads: 2^-24 over cells of 1 / 64 and steep slopes at their
                // edges.
                CHECK(s.weight.g * s.pdf == Approx(e.value.g).epsilon(2e-3).margin(1e-5));
            }
            double statistic = 0, inside = 0, pooled_expected = 0, pooled_found = 0;
            int cells = 0;
            const auto add = [&](double e, double f) {
                // The midpoint rule's error of up to 1 % a cell, at the horizon and the seams, stands beside the
                // binomial one.
                statistic += (f - e) * (f - e) / (e + 1e-4 * e * e);
                ++cells;
            };
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const double e = expected[i] * n;
                inside += expected[i];
                if (e >= 20) add(e, found[i]);
                else pooled_expected += e, pooled_found += found[i];
            }
            if (pooled_expected >= 20) add(pooled_expected, pooled_found);
            CAPTURE(cosine, statistic, cells, inside, lost / n);
            CHECK(inside + lost / n == Approx(1).margin(0.01));
            CHECK(chi_square_tail(statistic, cells - 1) > 1e-4 / 9);
            const auto mean =
                average(40'000, [&] { return static_cast<double>(bsdf.sample(wo, 0.5f, random.two()).weight.g); });
            // The albedo is tabulated by 576 samples at 17 cosines; of the last surface it is the mean over phi.
            CHECK(static_cast<double>(bsdf.albedo(wo).g) == Approx(mean.mean).margin(0.03));
        }
    }
    CHECK(tables[0]->albedo(0.9f).g == Approx(0.6).epsilon(0.01));
}

TEST_CASE("a measured spectrum becomes the colour that the importer gives it", "[materials][measured][color]") {
    Resolution resolution;
    resolution.wavelengths = {360, 450, 520, 600, 700, 1000};
    resolution.spectrum = {0.1f, 0.2f, 0.6f, 0.7f, 0.3f, 0.3f};
    const Folder folder;
    const auto table = read_back(folder, measured_test::lambert(1), resolution);
    raylex::Parameter pairs;
    pairs.name = "reflectance";
    pairs.type = raylex::ParameterType::spectrum;
    for (std::size_t i = 0; i < 6; ++i)
        pairs.numbers.insert(pairs.numbers.end(), {double{resolution.wavelengths[i]}, double{resolution.spectrum[i]}});
    const auto colour = resolve_spectrum(pairs, SpectrumRole::albedo, {});
    REQUIRE(colour.ok());
    const Rgb value = table->value(local_direction(0.8f), local_direction(0.7f, 2));
    for (int c : {0, 2}) CHECK(value[c] / value.g == Approx((*colour)[c] / colour->g).epsilon(1e-4));
    CHECK(value.g == Approx(colour->g * 0.7f / pi).epsilon(0.02));  // the tables' own error
}

TEST_CASE("a measured file that is missing or damaged is an error that says so", "[materials][measured]") {
    const Folder folder;
    Resolution small;
    small.normals = 8;
    small.square = 4;
    const std::string good = file_of(measured_test::lambert(0.5), small);
    const auto built = [&](const std::string& name) {
        return raylex::transport::import_pbrt_text(
            "WorldBegin\nMaterial \"measured\" \"string filename\" \"" + name + "\"\nShape \"sphere\"", "test.pbrt");
    };
    const auto missing = built("nowhere.bsdf");
    REQUIRE_FALSE(missing.ok());
    CHECK(missing.error().line == 2);
    CHECK(missing.error().to_string().find("nowhere.bsdf") != std::string::npos);
    const auto error_of_bytes = [&](const std::string& bytes) {
        const auto scene = built(folder.write("bad.bsdf", bytes));
        REQUIRE(scene.ok());
        const auto scene_built = BuiltScene::build(*scene);
        return scene_built.ok() ? std::string() : scene_built.error().to_string();
    };
    CHECK(error_of_bytes(good).empty());
    for (std::size_t length = 0; length < good.size(); length += 61) {
        CAPTURE(length);
        const std::string message = error_of_bytes(good.substr(0, length));
        CHECK(message.find("test.pbrt:2") != std::string::npos);
    }
    Random random(47);
    for (int i = 0; i < 300; ++i) {  // hostile headers end in a message or in a material, in no time
        std::string bytes = good;
        for (int k = 0; k < 3; ++k)
            bytes[static_cast<std::size_t>(random.one() * 400)] = static_cast<char>(random.bits());
        error_of_bytes(bytes);
    }
    // A thousand fields that name the same bytes, which took a thousand times as much memory as the file.
    std::string shared = good.substr(0, 14) + std::string("\xe8\x03\0\0", 4);
    for (int i = 0; i < 1000; ++i) {
        const std::string name = "f" + std::to_string(i);
        shared += std::string{static_cast<char>(name.size()), '\0'} + name +
                  std::string("\x01\0\x0a\0\0\0\0\0\0\0\0", 11) + std::string("\xe8\x03\0\0\0\0\0\0", 8);
    }
    CHECK(error_of_bytes(shared).find("its fields overlap") != std::string::npos);
    const auto nameless = import_pbrt_text("WorldBegin\nMaterial \"measured\"\nShape \"sphere\"", "test.pbrt");
    REQUIRE(nameless.ok());
    const auto refused = BuiltScene::build(*nameless);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().to_string().find("filename") != std::string::npos);
}

TEST_CASE("values that no measurement has are taken as 0, with a word", "[materials][measured][law6]") {
    const Folder folder;
    Resolution small;
    small.normals = 8;
    small.square = 4;
    std::string bytes = file_of(measured_test::lambert(0.5), small);
    // The spectra stand last: four values of them, the largest float, no number, infinite, and one that is fine.
    const char bad[] = "\xff\xff\x7f\x7f\x00\x00\xc0\x7f\x00\x00\x80\xff\x00\x00\x00\x3f";
    bytes.replace(bytes.size() - 16, 16, bad, 16);
    const auto scene = raylex::transport::import_pbrt_text("WorldBegin\nMaterial \"measured\" \"string filename\" \"" +
                                                               folder.write("bad.bsdf", bytes) + "\"\nShape \"sphere\"",
                                                           "test.pbrt");
    REQUIRE(scene.ok());
    const auto built = BuiltScene::build(*scene);
    REQUIRE(built.ok());
    REQUIRE((*built)->warnings.size() == 1);
    CHECK((*built)->warnings[0].line == 2);
    CHECK((*built)->warnings[0].message.find("3 values not finite or beyond 1e9, first number ") != std::string::npos);
    CHECK((*built)->warnings[0].message.find("; taken as 0") != std::string::npos);
}
