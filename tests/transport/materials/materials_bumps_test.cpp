// Bump and normal maps: turned frames against closed forms, on every shape, under every material, by every method.
#include <bit>
#include <numbers>

#include "transport/materials/material.h"
#include "transport/replicates.h"
#include "transport/textures/pattern.h"

using namespace render_test;
using raylex::Result;
using raylex::test::Folder;
using transport::Real;
using transport::Vec3;

namespace {

/// slope_u u + slope_v v + height sin(frequency u) sin(frequency v)
class HeightPattern final : public transport::Pattern {
  public:
    HeightPattern(Real su, Real sv, Real height, Real frequency)
        : slope_u_(su), slope_v_(sv), height_(height), frequency_(frequency) {}
    [[nodiscard]] transport::Rgb rgb(const transport::PatternPoint& p) const override {
        return transport::Rgb(real(p));
    }
    [[nodiscard]] Real real(const transport::PatternPoint& p) const override {
        return slope_u_ * p.at.u + slope_v_ * p.at.v +
               height_ * std::sin(frequency_ * p.at.u) * std::sin(frequency_ * p.at.v);
    }

  private:
    Real slope_u_, slope_v_, height_, frequency_;
};

void register_heights() {
    using enum ParameterType;
    transport::pattern_registry().add(
        {"test:heights",
         "for this test",
         {{"slope_u", real, "0", ""},
          {"slope_v", real, "0", ""},
          {"height", real, "0", ""},
          {"frequency", real, "0", ""}},
         [](transport::PatternReader& reader) -> Result<std::unique_ptr<transport::Pattern>> {
             return std::unique_ptr<transport::Pattern>(
                 std::make_unique<HeightPattern>(reader.real("slope_u", 0), reader.real("slope_v", 0),
                                                 reader.real("height", 0), reader.real("frequency", 0)));
         }});
}

/// One shape before the camera, which looks down; light comes from (3, 2, 5).
std::string tilted_scene(const std::string& texture, const std::string& material, const std::string& shape) {
    return R"(
        Film "rgb" "integer xresolution" 6 "integer yresolution" 6
        PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
        LookAt 0 0 4  0 0 0  0 1 0
        Camera "perspective" "float fov" 10
        WorldBegin
        LightSource "distant" "rgb L" [1 1 1] "point3 from" [3 2 5] "point3 to" [0 0 0] )" +
           texture + material + shape;
}

double mean_of(const std::string& text) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.paths.max_depth = 1;
    return estimate(render_of(scene_of(text), settings)).mean;
}

/// What a white surface of normal (x, y, 1) sends back of that light.
double lambert(double x, double y) {
    return std::max(0.0, (3 * x + 2 * y + 5) / std::sqrt(38.0) / std::sqrt(x * x + y * y + 1)) / std::numbers::pi;
}

const std::string quad_2x4 =
    R"("integer indices" [0 1 2 0 2 3] "point3 P" [-1 -2 0 1 -2 0 1 2 0 -1 2 0] "point2 uv" [0 0 1 0 1 1 0 1])";
const std::string white = R"( Material "diffuse" "rgb reflectance" [1 1 1] "texture displacement" "h" )";
const std::string ramp = R"( Texture "h" "float" "test:heights" "float slope_u" 0.6 "float slope_v" -0.8 )";

}  // namespace

TEST_CASE("a sloping displacement shades a flat shape as if it stood so, whatever the shape", "[materials][render]") {
    register_heights();
    // On 2 x 4 units the slopes are 0.3 along x and -0.2 along y: normal (-0.3, 0.2, 1). Heights are along the normal,
    // so turning the shape over turns the slopes.
    const double expected = lambert(-0.3, 0.2);
    struct Case {
        const char* what;
        std::string shape;
        double expected;
    };
    const Case cases[] = {
        {"triangles", "Shape \"trianglemesh\" " + quad_2x4, expected},
        {"triangles with vertex normals",
         "Shape \"trianglemesh\" \"point2 uv\" [0 0 .5 0 .5 1 0 1] \"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1] "
         "\"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-1 -2 0 0 -2 0 0 2 0 -1 2 0] "
         "Shape \"trianglemesh\" \"point2 uv\" [0 0 .5 0 .5 .5 0 .5] \"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1] "
         "\"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-1 -1 0.1 1 -1 0.1 1 1 0.1 -1 1 0.1]",
         lambert(-0.15, 0.2)},  // u and v by 4 units each
        {"turned over", "ReverseOrientation Shape \"trianglemesh\" " + quad_2x4, lambert(0.3, -0.2)},
        {"patch", "Shape \"bilinearmesh\" \"point3 P\" [-1 -2 0 1 -2 0 -1 2 0 1 2 0]", expected},
        {"patch with normals and texture coordinates",
         "Shape \"bilinearmesh\" \"point3 P\" [-1 -2 0 1 -2 0 -1 2 0 1 2 0] \"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1] "
         "\"point2 uv\" [0 0 0 -1 1 0 1 -1]",
         lambert(-0.4, -0.15)},  // v is -x / 2 + ..., u is y / 4: slopes 0.8 / 2 and 0.6 / 4
        {"scaled",
         "Scale 0.5 2 3 Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
         "\"point3 P\" [-2 -1 0 2 -1 0 2 1 0 -2 1 0] \"point2 uv\" [0 0 1 0 1 1 0 1]",
         expected},
    };
    for (const Case& c : cases) {
        CAPTURE(c.what);
        // Slopes are differences of heights of about 0.5, rounded by 2^-25, over steps of 2^-14 and more.
        CHECK(mean_of(tilted_scene(ramp, white, c.shape)) == Approx(c.expected).epsilon(2e-3));
    }
    CHECK(mean_of(tilted_scene(" Texture \"h\" \"float\" \"constant\" \"float value\" 0.7 ", white, cases[0].shape)) ==
          Approx(lambert(0, 0)).epsilon(1e-5));
}

TEST_CASE("a normal map turns the frame as the displacement of its slopes does", "[materials][render]") {
    register_heights();
    // One texel with the normal (-0.3, 0.2, 1), coded as (1 + n) / 2; a little endian PFM.
    const double l = std::sqrt(1.13);
    const Folder folder;
    const auto map_of = [&](const std::string& name, double x, double y, double z) {
        std::string bytes = "PF\n1 1\n-1\n";
        for (const double each : {x, y, z}) {
            const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>((each + 1) / 2));
            for (int b = 0; b < 4; ++b) bytes += static_cast<char>(bits >> (8 * b) & 255);
        }
        return folder.write(name, bytes);
    };
    const auto material = [](const std::string& file) {
        return " Material \"diffuse\" \"rgb reflectance\" [1 1 1] \"string normalmap\" \"" + file + "\" ";
    };
    const std::string shape = "Shape \"trianglemesh\" " + quad_2x4;
    CHECK(mean_of(tilted_scene("", material(map_of("n.pfm", -0.3 / l, 0.2 / l, 1 / l)), shape)) ==
          Approx(lambert(-0.3, 0.2)).epsilon(1e-5));
    // Where both are given the map alone counts, as in pbrt (SurfaceInteraction::GetBSDF).
    std::string both = material(map_of("n.pfm", 0.3 / l, -0.2 / l, 1 / l));
    both += " \"texture displacement\" \"h\" ";
    CHECK(mean_of(tilted_scene(ramp, both, shape)) == Approx(lambert(0.3, -0.2)).epsilon(1e-5));
    // No length, no normal: the surface's own.
    CHECK(mean_of(tilted_scene("", material(map_of("zero.pfm", 0, 0, 0)), shape)) ==
          Approx(lambert(0, 0)).epsilon(1e-5));

    const auto refusal = [&](const std::string& text) {
        auto scene = transport::import_pbrt_text(text, "bad.pbrt");
        if (!scene) return scene.error().to_string();
        const auto built = transport::BuiltScene::build(*scene);
        return built.ok() ? std::string() : built.error().to_string();
    };
    const std::string grey = folder.write("grey.pfm", std::string("Pf\n1 1\n-1\n") + std::string(4, '\0'));
    const std::string message = refusal(tilted_scene("", material(grey), shape));
    CHECK(message.find("bad.pbrt:7") != std::string::npos);
    CHECK(message.find("expected three") != std::string::npos);
    CHECK(refusal(tilted_scene("", material("none.png"), shape)).find("none.png") != std::string::npos);
    CHECK(refusal(tilted_scene("", white, shape)).find("no texture is called 'h'") != std::string::npos);
}

TEST_CASE("tangents are the derivatives of points and normals, on every shape", "[geometry]") {
    const std::string smooth_triangle =
        R"("integer indices" [0 1 2] "point3 P" [-1 -1 0 1 -1 0.2 0 1 0.1] "point2 uv" [0.1 0 1 0.2 0.4 1])";
    const std::string shapes[] = {
        "Shape \"trianglemesh\" " + smooth_triangle,
        "Shape \"trianglemesh\" \"normal N\" [-.6 0 .8 .6 0 .8 0 .3 1] " + smooth_triangle,
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [-1 -1 0 1 -1 0.2 0 1 0.1]",
        "Shape \"sphere\" \"float radius\" 1.5",
        "ReverseOrientation Scale 1 1.3 0.8 Shape \"sphere\"",
        "Rotate 90 1 0 0 Shape \"cylinder\" \"float radius\" 1",
        "Shape \"disk\" \"float radius\" 2",
        "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0.4 -1 1 0.3 1 1 -0.4]",
        "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0.4 -1 1 0.3 1 1 -0.4] "
        "\"point2 uv\" [0 0 1 0.2 0.1 1 1.3 1.1]",
        "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0.4 -1 1 0.3 1 1 -0.4] "
        "\"normal N\" [-.2 0 1 .3 0 1 0 .4 1 0 -.1 1]"};
    for (const std::string& shape : shapes)
        for (const bool instanced : {false, true}) {
            CAPTURE(shape, instanced);
            const std::string text = instanced ? "ObjectBegin \"o\" " + shape +
                                                     " ObjectEnd Scale 1.2 0.9 1.5 Rotate 20 1 2 0 ObjectInstance \"o\""
                                               : shape;
            const auto scene = scene_of("WorldBegin " + text);
            transport::TextureTable textures;
            const auto geometry = transport::EmbreeScene::build(scene, textures, {});
            REQUIRE(geometry.ok());
            const auto at = [&](Real x, Real y, transport::Hit& hit) {
                transport::Ray ray;
                ray.origin = {x, y, 6};
                ray.direction = {0, 0, -1};
                geometry->intersect({&ray, 1}, {&hit, 1});
                REQUIRE(hit.valid());
                transport::SurfacePoint point;
                transport::SurfaceSource source;
                geometry->surfaces({&ray, 1}, {&hit, 1}, {&point, 1}, {&source, 1});
                return point;
            };
            transport::Hit hit, other;
            const transport::SurfacePoint here = at(0.11f, -0.23f, hit);
            const transport::SurfaceTangents tangents = geometry->tangents(hit, here);
            const bool has_normals = shape.find("normal N") != std::string::npos;
            for (const Vec3 step : {Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
                constexpr Real h = 4e-3f;
                const auto after = at(0.11f + h * step.x, -0.23f + h * step.y, other),
                           before = at(0.11f - h * step.x, -0.23f - h * step.y, other);
                const Real du = after.u - before.u, dv = after.v - before.v;
                // Central differences: h^2 times third derivatives of order 1, and float's 2^-23 over h.
                const Vec3 normal =
                    tangents.dndu * du + tangents.dndv * dv - (after.shading_normal - before.shading_normal);
                CHECK(length(normal) <= 2 * h * Real(2e-3));
                const Vec3 position = tangents.dpdu * du + tangents.dpdv * dv - (after.position - before.position);
                if (!has_normals) CHECK(length(position) <= 2 * h * Real(2e-3));
            }
            // Vertex normals have turned these into the plane that shades.
            if (has_normals && !instanced) {
                CHECK(std::abs(dot(tangents.dpdu, here.shading_normal)) <= 1e-5f * length(tangents.dpdu));
                CHECK(std::abs(dot(tangents.dpdv, here.shading_normal)) <= 1e-5f * length(tangents.dpdv));
            }
        }
}

TEST_CASE("every material takes bumps: no light comes out of nothing, none is lost to NaN, at any angle",
          "[materials][render][gate]") {
    register_heights();
    const std::string text = film + R"(
        LookAt 0 0.25 3  0 0 0  0 1 0
        Camera "perspective" "float fov" 40
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        Texture "h" "float" "test:heights" "float height" 0.1 "float frequency" 40
        MakeNamedMaterial "bumpy" "string type" "diffuse" "rgb reflectance" [1 1 1] "texture displacement" "h"
        MakeNamedMaterial "metal" "string type" "conductor" "float roughness" 0.2 "texture displacement" "h"
        )";
    const std::string shapes = R"(
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 3 3 0 3 3 0 -3 -3 0 -3]
        Translate 0 0.5 0 Shape "sphere" "float radius" 0.5)";
    int tested = 0;
    for (const auto& entry : transport::material_registry().entries()) {
        if (entry.name.starts_with("test:") || entry.name == "interface" || entry.name == "measured") continue;
        CAPTURE(entry.name);
        const std::string material = entry.name == "mix"
                                         ? "Material \"mix\" \"string materials\" [\"bumpy\" \"metal\"]"
                                         : "Material \"" + entry.name + "\" \"texture displacement\" \"h\"";
        transport::RenderSettings settings;
        settings.samples.per_pixel = 16;
        settings.paths.max_depth = 8;
        settings.channels.list = {lpe_channel("seen", "CB"), lpe_channel("scattered", "C.+B")};
        const auto output = render_of(scene_of(text + material + shapes), settings);  // no invalid samples
        const Estimate sky = estimate(output, 1), scattered = estimate(output, 2);
        // Shading normals break reciprocity, not energy: what the closure sends is at most 1 of a sky of 1. Slopes of
        // 4 turn much of it below the surface, where a diffuse one keeps it.
        CHECK(sky.mean + scattered.mean <= 1 + 4.5 * scattered.error);
        CHECK(scattered.mean > 0.02);
        ++tested;
    }
    CHECK(tested >= 11);
}

TEST_CASE("bumps are seen alike from the camera and from lights", "[materials][bdpt][lighttracer][statistical][gate]") {
    register_heights();
    std::string text = room;
    const auto put = [&](const std::string& before, const std::string& more) {
        text.replace(text.find(before), before.size(), before + more);
    };
    put("WorldBegin", R"( Texture "h" "float" "test:heights" "float height" 0.02 "float frequency" 25 )");
    put("\"rgb reflectance\" [0.7 0.6 0.5]", " \"texture displacement\" \"h\"");
    put("\"rgb reflectance\" [0.8 0.7 0.6] \"float roughness\" 0.1", " \"texture displacement\" \"h\"");
    put("\"rgb reflectance\" [0.2 0.5 0.7] \"float roughness\" 0.05", " \"texture displacement\" \"h\"");
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.samples.per_pixel = 192;
    settings.film.resolution = {{18, 18}};
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    compare_with_path(text, settings, integrator_named(integrator), 12, 192,
                      {"C<.[DG]>L", "C<.[DG]>B", "C<RD><RD>+[LB]", "C<RG>.*L", "C<RD><.G>.*[LB]"});
}

TEST_CASE("a mix goes by the bumps of what it chose, and AOVs show the normal that shades and the plain one",
          "[materials][render]") {
    register_heights();
    const std::string named = R"(
        MakeNamedMaterial "bumpy" "string type" "diffuse" "rgb reflectance" [1 1 1] "texture displacement" "h"
        MakeNamedMaterial "flat" "string type" "diffuse" "rgb reflectance" [1 1 1]
        MakeNamedMaterial "inner" "string type" "mix" "string materials" ["flat" "bumpy"] "float amount" 1 )";
    const std::string shape = "Shape \"trianglemesh\" " + quad_2x4;
    const auto mixed = [&](double amount) {
        return tilted_scene(ramp,
                            named + "Material \"mix\" \"string materials\" [\"flat\" \"inner\"] \"float amount\" " +
                                std::to_string(amount) + " ",
                            shape);
    };
    const double flat = lambert(0, 0), bumpy = lambert(-0.3, 0.2);
    CHECK(mean_of(mixed(0)) == Approx(flat).epsilon(1e-5));
    CHECK(mean_of(mixed(1)) == Approx(bumpy).epsilon(2e-3));
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.paths.max_depth = 1;
    settings.channels.list = {aov("Nn"), aov("Non")};
    const auto half = render_of(scene_of(mixed(0.5)), settings);
    // 36 x 64 samples of one of two values: 4.5 standard errors.
    CHECK(std::abs(estimate(half).mean - (flat + bumpy) / 2) < 4.5 * std::abs(flat - bumpy) / 2 / 48);
    settings.samples.per_pixel = 4;
    const auto output = render_of(scene_of(mixed(1)), settings);
    const std::vector<double> normals = output.frame_buffer.resolve(1), plain = output.frame_buffer.resolve(2);
    const double l = std::sqrt(1.13);
    for (std::size_t i = 0; i < normals.size(); i += 3) {
        CHECK(std::abs(normals[i]) == Approx(0.3 / l).epsilon(2e-3));
        CHECK(std::abs(normals[i + 1]) == Approx(0.2 / l).epsilon(2e-3));
        CHECK(std::abs(normals[i + 2]) == Approx(1 / l).epsilon(2e-3));
        // The shape faces the camera.
        CHECK(plain[i] == 0);
        CHECK(plain[i + 1] == 0);
        CHECK(plain[i + 2] == -1);
    }
}

TEST_CASE("a mix without a name may use materials defined after it, one with a name those before it", "[materials]") {
    const std::string shape = "Shape \"trianglemesh\" " + quad_2x4;
    const std::string later = R"(MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [1 1 1]
                                 MakeNamedMaterial "b" "string type" "diffuse" "rgb reflectance" [0 0 0] )";
    const std::string mix = "\"string materials\" [\"b\" \"a\"] \"float amount\" 1 ";
    CHECK(mean_of(tilted_scene("", "Material \"mix\" " + mix, shape + " " + later)) ==
          Approx(lambert(0, 0)).epsilon(1e-5));
    const auto built = transport::BuiltScene::build(
        scene_of(tilted_scene("", "MakeNamedMaterial \"m\" \"string type\" \"mix\" " + mix, shape + " " + later)));
    REQUIRE_FALSE(built.ok());
    CHECK(built.error().to_string().find("before this one") != std::string::npos);
}
