// The interfaces of plugins, used as a plugin uses them: closures, lobes, patterns, and display services for both.
#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "display/services/samples/display_services.h"
#include "tests/transport/materials_scene.h"
#include "tests/transport/materials_support.h"
#include "transport/materials/material.h"
#include "transport/materials/material_inputs.h"
#include "transport/textures/pattern.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

/// A Lambertian surface, as a plugin would implement it, with a reflectance in the material.
struct OutsideClosure {
    const Rgb* reflectance = nullptr;

    [[nodiscard]] float pdf(const Vec3& wo, const Vec3& wi) const { return LambertClosure::pdf(wo, wi); }
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        BsdfEvaluation result;
        result.pdf = pdf(wo, wi);
        result.value = *reflectance * result.pdf;
        result.lobes.add(lobes::diffuse, result.value);
        return result;
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, float, const Vec2& u) const {
        BsdfSample result;
        result.wi = sample_cosine_hemisphere(u);
        result.wi.z = std::copysign(result.wi.z, wo.z);
        const BsdfEvaluation f = evaluate(wo, result.wi);
        result.pdf = f.pdf;
        result.weight = *reflectance;
        result.lobes = f.lobes;
        return result;
    }
    [[nodiscard]] Rgb albedo(float) const { return *reflectance; }
    [[nodiscard]] bool has_density() const { return true; }
};

/// Passes its input through and writes it to the first channel; a float texture writes to the second.
class WritingPattern final : public Pattern {
  public:
    explicit WritingPattern(TextureId input) : input_(input) {}
    [[nodiscard]] Rgb rgb(const PatternPoint& point) const override {
        const Rgb value = point.rgb(input_);
        if (point.services().camera_sees()) point.services().display->write(0, point.services().row, value);
        return value;
    }
    [[nodiscard]] float real(const PatternPoint& point) const override {
        const float value = point.real(input_);
        if (point.services().camera_sees()) point.services().display->write(1, point.services().row, value);
        return value;
    }

  private:
    TextureId input_;
};

void register_writing_pattern() {
    pattern_registry().add({"test:writing",
                            "for this test",
                            {{"input", ParameterType::texture, "1", "passed on"}},
                            [](PatternReader& reader) -> Result<std::unique_ptr<Pattern>> {
                                const TextureId input = reader.input("input", 1);
                                return std::unique_ptr<Pattern>(std::make_unique<WritingPattern>(input));
                            }});
}

std::vector<display::ChannelDefinition> two_channels() {
    std::vector<display::ChannelDefinition> channels(2);
    channels[0].name = "seen";
    channels[1].name = "number";
    channels[1].type = display::ChannelType::real;
    return channels;
}

}  // namespace

TEST_CASE("a closure of a plugin behaves like a built-in one", "[materials][plugins]") {
    const Rgb reflectance(0.2f, 0.5f, 0.7f);
    Bsdf inside, outside;
    inside.set(tilted_frame(), LambertClosure{reflectance});
    outside.set_custom(tilted_frame(), OutsideClosure{&reflectance});
    CHECK(outside.has_density());
    CHECK(outside.holds<CustomClosure>());
    Random random(4);
    for (int i = 0; i < 200; ++i) {
        const Vec3 wo = sample_uniform_sphere(random.two()), wi = sample_uniform_sphere(random.two());
        const BsdfEvaluation a = inside.evaluate(wo, wi), b = outside.evaluate(wo, wi);
        // Cosines by a dot product and by the frame: a few roundings of numbers up to 1.
        for (int c = 0; c < 3; ++c) CHECK(a.value[c] == Approx(b.value[c]).margin(1e-6));
        CHECK(a.pdf == Approx(b.pdf).margin(1e-6));
        CHECK(outside.pdf(wo, wi) == b.pdf);
        const Vec2 u = random.two();
        const BsdfSample s = inside.sample(wo, 0.5f, u), t = outside.sample(wo, 0.5f, u);
        CHECK(length(s.wi - t.wi) < 1e-6f);
        CHECK(s.weight == t.weight);
        CHECK(t.lobes.count == 1);
        CHECK(t.lobes.entry[0].lobe == lobes::diffuse);
        CHECK(outside.albedo(wo) == reflectance);
    }
    const Bsdf copy = outside;  // closures are copied in batches
    CHECK(copy.pdf({0, 0, 1}, {0, 0, 1}) == outside.pdf({0, 0, 1}, {0, 0, 1}));
}

TEST_CASE("a lobe of a plugin gets a row of the event table, and an equal lobe the same row", "[materials][plugins]") {
    const std::size_t before = lobe_kinds().size();
    CHECK(add_lobe({lpe::EventType::reflection, lpe::Scatter::diffuse, "diffuse"}) == lobes::diffuse);
    CHECK(lobe_kinds().size() == before);
    const auto velvet = add_lobe({lpe::EventType::reflection, lpe::Scatter::glossy, "test velvet"});
    REQUIRE(velvet);
    CHECK(lobe_kinds()[*velvet].name == std::string("test velvet"));
    CHECK(add_lobe({lpe::EventType::reflection, lpe::Scatter::glossy, "test velvet"}) == velvet);
    CHECK(add_lobe({lpe::EventType::transmission, lpe::Scatter::glossy, "test velvet"}) != velvet);
    CHECK(lobe_kinds().size() == before + 2);
}

TEST_CASE("a pattern passes its inputs through, and writes only where the camera sees it", "[textures][plugins]") {
    register_writing_pattern();
    SceneDescription scene;
    scene.textures.push_back(colour_texture("constant", "plain", {rgb("value", 0.25, 0.5, 0.75)}));
    scene.textures.push_back(colour_texture("test:writing", "tee", {texture("input", "plain")}));
    scene.textures.push_back(real_texture("test:writing", "rough", {real("input", 0.125)}));
    scene.materials.push_back(entity("diffuse", {texture("reflectance", "tee")}));
    scene.materials.push_back(entity("conductor", {texture("roughness", "rough")}));
    auto textures = TextureTable::build(scene);
    REQUIRE(textures);
    auto materials = MaterialTable::build(scene, *textures);
    REQUIRE(materials);

    display::SampleTable table(two_channels(), 4);
    display::DisplayServices services(table);
    table.begin(std::array<display::CameraRow, 4>{});
    std::array<SurfacePoint, 4> points{};
    for (SurfacePoint& point : points) point.shading_normal = point.geometric_normal = point.wo = {0, 0, 1};
    points[0].services = {&services, 2, 0};  // first hits of rows 2 and 3; the others are deeper in paths
    points[1].services = {&services, 0, 1};
    points[2].services = {&services, 3, 0};
    points[2].material = points[3].material = 1;
    std::array<Bsdf, 4> closures;
    materials->shade(*textures, points, closures);
    CHECK(closures[0].albedo({0, 0, 1}) == Rgb(0.25f, 0.5f, 0.75f));
    CHECK(closures[1].albedo({0, 0, 1}) == Rgb(0.25f, 0.5f, 0.75f));
    for (int row = 0; row < 4; ++row) {
        CHECK(table.written(0, row) == (row == 2));
        CHECK(table.written(1, row) == (row == 3));
    }
    CHECK(table.values(0)[6] == 0.25);
    CHECK(table.values(1)[3] == 0.125);

    // Without services nothing is written and all points are shaded.
    table.begin(std::array<display::CameraRow, 4>{});
    for (SurfacePoint& point : points) point.services = {};
    materials->shade(*textures, points, closures);
    CHECK(closures[0].albedo({0, 0, 1}) == Rgb(0.25f, 0.5f, 0.75f));
    CHECK_FALSE(table.touched(0));
}

TEST_CASE("patterns' parameters are checked like those of built-in textures", "[textures][plugins][law7]") {
    register_writing_pattern();
    SceneDescription scene;
    scene.textures.push_back(colour_texture("test:writing", "tee", {texture("input", "nothing")}));
    const auto missing = TextureTable::build(scene);
    REQUIRE_FALSE(missing);
    CHECK(missing.error().message == "unknown colour texture 'nothing' for parameter 'input'");
    CHECK(missing.error().line == 7);
    scene.textures[0] = colour_texture("test:writnig", "tee", {});
    const auto unknown = TextureTable::build(scene);
    REQUIRE_FALSE(unknown);
    CHECK(unknown.error().hint == "did you mean 'test:writing'?");
    CHECK(unknown.error().line == 5);
}
